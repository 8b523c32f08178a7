// SPDX-License-Identifier: BSD-3-Clause
// CAN interfaces of a Linux board, as `ip link` would make them: an initramfs has no program that sets a bit
// rate.
#pragma once

#include <cstdint>
#include <string>

namespace sortie::drivers {

/// Makes a virtual bus of this name and switches it on. Needs the modules can and vcan, and root. False:
/// `problem` says what the kernel refused.
bool make_virtual_can(const std::string& name, std::string& problem);

/// Sets a controller's bit rate and switches it on. 0 bit/s: switches it off.
bool set_can_bitrate(const std::string& name, std::uint32_t bits_per_s, std::string& problem);

/// Switches any interface on, such as lo.
bool switch_on(const std::string& name, std::string& problem);

/// Moves an interface into the network namespace of a process. It is off there.
bool move_can_to(const std::string& name, int process, std::string& problem);

}  // namespace sortie::drivers
