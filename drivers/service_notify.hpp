// SPDX-License-Identifier: BSD-3-Clause
// Tells whoever supervises this process how it is: the datagrams that systemd takes on NOTIFY_SOCKET.
#pragma once

#include <sys/un.h>

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rt/time.hpp"

namespace sortie::drivers {

/// Says READY=1, WATCHDOG=1 and STOPPING=1. Reads NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID once; without
/// the first, each call does nothing. For a thread that is not real-time: a system call that does not wait.
/// What the supervisor does not take is counted and forgotten. No heap.
class ServiceNotify {
 public:
  ServiceNotify() noexcept;
  ~ServiceNotify();
  ServiceNotify(const ServiceNotify&) = delete;
  ServiceNotify& operator=(const ServiceNotify&) = delete;

  /// The run has begun.
  void ready() noexcept { send("READY=1"); }
  /// Call often; says so four times in the time that the watchdog waits.
  void alive(rt::Nanoseconds now_ns) noexcept;
  /// The run is about to end by itself.
  void stopping() noexcept { send("STOPPING=1"); }

  bool wanted() const { return socket_ >= 0; }
  std::uint64_t sent() const { return sent_; }
  std::uint64_t refused() const { return refused_; }

 private:
  void send(std::string_view text) noexcept;

  int socket_{-1};
  sockaddr_un name_{};
  std::size_t name_bytes_{};
  rt::Nanoseconds every_ns_{};  ///< 0: nobody waits for it
  rt::Nanoseconds next_ns_{};
  std::uint64_t sent_{};
  std::uint64_t refused_{};
};

}  // namespace sortie::drivers
