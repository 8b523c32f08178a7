// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/cpu_latency.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

namespace sortie::rt::posix {

CpuLatencyHold::CpuLatencyHold(const char* device) noexcept {
  file_ = open(device, O_WRONLY | O_CLOEXEC);
  const std::int32_t wanted_us = 0;
  if (file_ >= 0 && write(file_, &wanted_us, sizeof(wanted_us)) == sizeof(wanted_us)) return;
  const int error = errno;
  if (file_ >= 0) close(file_);
  file_ = -1;
  result_ = refusal("%s: %s; idle cores may sleep deeply and wake late; run as root, or once: chmod 666 %s",
                    device, std::strerror(error), device);
}

CpuLatencyHold::~CpuLatencyHold() {
  if (file_ >= 0) close(file_);
}

}  // namespace sortie::rt::posix
