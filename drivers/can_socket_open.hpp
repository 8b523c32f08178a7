// SPDX-License-Identifier: BSD-3-Clause
// What the ports for classical CAN and for CAN FD share. Internal to them.
#pragma once

#include <string>

#include "drivers/can_socket_config.hpp"
#include "rt/status.hpp"

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

}  // namespace sortie::drivers
