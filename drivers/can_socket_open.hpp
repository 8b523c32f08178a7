// SPDX-License-Identifier: BSD-3-Clause
// What the ports for classical CAN and for CAN FD share. Internal to them.
#pragma once

#include <string>

#include "drivers/can_socket_config.hpp"
#include "rt/status.hpp"
#if defined(__linux__)
#include "drivers/kernel_stamp.hpp"
#endif

namespace sortie::drivers {

/// Which frames a socket carries.
enum class CanSocketKind : std::uint8_t { classical, fd };

/// Opens and binds a raw socket that never blocks; as SocketCan::open. With `fd` also not_supported: the
/// interface carries no FD frames. `descriptor` is the caller's from then on.
[[nodiscard]] Status open_can_socket(const SocketCanConfig& config, CanSocketKind kind, int& descriptor,
                                     std::string& problem);

/// The same again, of a configuration that could be opened once: without memory, and without words. A
/// descriptor, or -1.
[[nodiscard]] int reopen_can_socket(const SocketCanConfig& config, CanSocketKind kind) noexcept;

/// What a failed system call means for a port; `when_busy` where it would have to wait.
[[nodiscard]] Status meaning_of_can_error(int error, Status when_busy) noexcept;

#if defined(__linux__)
/// What came out of a socket.
struct CanPacket {
  Status status{};  ///< ok; empty; disconnected; malformed: cut off
  int error{};      ///< of the system, where it is disconnected
  std::size_t bytes{};
  KernelNote note;
};

/// Takes one packet of at most `room` bytes, without waiting.
[[nodiscard]] CanPacket take_can_packet(int descriptor, void* to, std::size_t room) noexcept;
#endif

}  // namespace sortie::drivers
