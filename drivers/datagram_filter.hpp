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

/// The rule that a datagram of this length or more begins with these bytes from `offset` on.
FilterRule bytes_at(std::uint16_t offset, std::span<const std::uint8_t> bytes);

/// From now on the UDP socket takes only what fits to one of the rules. False where the kernel has no
/// filters; then it takes everything, and errno says why. It is no protection: whoever sends can send what
/// fits.
bool set_filter(int socket, std::span<const FilterRule> any_of);

}  // namespace sortie::drivers
