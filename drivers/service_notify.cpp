// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/service_notify.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace sortie::drivers {
namespace {

// The variable as a number above 0, or 0.
std::uint64_t number_in(const char* variable) {
  const char* text = std::getenv(variable);
  if (text == nullptr || *text < '0' || *text > '9') return 0;
  char* end = nullptr;
  const std::uint64_t number = std::strtoull(text, &end, 10);
  return *end == '\0' ? number : 0;
}

}  // namespace

ServiceNotify::ServiceNotify() noexcept {
  const char* path = std::getenv("NOTIFY_SOCKET");
  if (path == nullptr || (path[0] != '/' && path[0] != '@')) return;
  const std::size_t length = std::strlen(path);
  if (length < 2 || length >= sizeof(name_.sun_path)) return;
  name_.sun_family = AF_UNIX;
  std::memcpy(name_.sun_path, path, length);
  if (path[0] == '@') name_.sun_path[0] = '\0';  // a name without a file
  name_bytes_ = offsetof(sockaddr_un, sun_path) + length + (path[0] == '@' ? 0 : 1);
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const std::uint64_t limit_us = number_in("WATCHDOG_USEC");
  const std::uint64_t whose = number_in("WATCHDOG_PID");
  constexpr std::uint64_t kMost_us = 86'400'000'000;  // beyond a day nobody watches
  if (limit_us > 0 && limit_us < kMost_us && (whose == 0 || whose == static_cast<std::uint64_t>(getpid())))
    every_ns_ = static_cast<rt::Nanoseconds>(limit_us) * rt::kNanosecondsPerMicrosecond / 4;
}

ServiceNotify::~ServiceNotify() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceNotify::alive(rt::Nanoseconds now_ns) noexcept {
  if (every_ns_ == 0 || now_ns < next_ns_) return;
  next_ns_ = now_ns + every_ns_;
  send("WATCHDOG=1");
}

void ServiceNotify::send(std::string_view text) noexcept {
  if (socket_ < 0) return;
  const ssize_t gone =
      ::sendto(socket_, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
               reinterpret_cast<const sockaddr*>(&name_), static_cast<socklen_t>(name_bytes_));
  ++(gone == static_cast<ssize_t>(text.size()) ? sent_ : refused_);
}

}  // namespace sortie::drivers
