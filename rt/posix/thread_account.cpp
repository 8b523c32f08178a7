// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/thread_account.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

namespace sortie::rt::posix {

ThreadAccountFile::~ThreadAccountFile() {
  if (file_ >= 0) close(file_);
}

SetupResult ThreadAccountFile::open_for_this_thread() noexcept {
  if (file_ >= 0) close(file_);
  file_ = open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC);
  ThreadAccount account;
  if (file_ >= 0 && read(account)) return {};
  const SetupResult result = refusal(
      "causes of delays: /proc/thread-self/schedstat: %s; mount /proc, or use a kernel with "
      "CONFIG_SCHED_INFO",
      file_ < 0 ? std::strerror(errno) : "holds no numbers");
  if (file_ >= 0) close(file_);
  file_ = -1;
  return result;
}

bool ThreadAccountFile::read(ThreadAccount& account) const noexcept {
  char text[96];
  const ssize_t got = pread(file_, text, sizeof(text), 0);
  if (got <= 0) return false;
  std::uint64_t numbers[3]{};
  const char* at = text;
  const char* const end = text + got;
  for (std::uint64_t& number : numbers) {
    const auto [stop, error] = std::from_chars(at, end, number);
    if (error != std::errc{}) return false;
    at = stop == end ? end : stop + 1;
  }
  account = {static_cast<Nanoseconds>(numbers[0]), static_cast<Nanoseconds>(numbers[1]), numbers[2]};
  return true;
}

std::uint64_t voluntary_switches() noexcept {
  rusage usage{};
  return getrusage(RUSAGE_THREAD, &usage) == 0 ? static_cast<std::uint64_t>(usage.ru_nvcsw) : 0;
}

}  // namespace sortie::rt::posix
