// SPDX-License-Identifier: BSD-3-Clause
// Which datagrams a socket wants, judged by the kernel: what it does not want takes no room in its queue.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sortie::drivers {

/// A byte of a datagram that must be so.
struct FilterByte {
  std::uint16_t offset{};
  std::uint8_t value{};
};
/// All of these. One rule holds at most kMostFilterBytes.
using FilterRule = std::vector<FilterByte>;
inline constexpr std::size_t kMostFilterBytes = 64;

/// LCM datagrams whose form is that of a halt to a drive, or of a stop to a pilot. Whether they are is for
/// their tag to say. Takes heap.
std::vector<FilterRule> stop_filter();

/// From now on the UDP socket takes only what fits to one of the rules. False where the kernel has no
/// filters; then it takes everything, and errno says why. It is no protection: whoever sends can send what
/// fits.
bool set_filter(int socket, std::span<const FilterRule> any_of);

}  // namespace sortie::drivers
