// SPDX-License-Identifier: BSD-3-Clause
// One LCM datagram, taken apart without trusting it. Form, big endian: u32 "LC02", u32 sequence, channel,
// zero, payload.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "rt/status.hpp"

namespace sortie::drivers {

/// A whole message in one datagram; views of the datagram's bytes.
struct Lc02Message {
  std::uint32_t sequence{};
  std::string_view channel;  ///< 1 to 63 bytes, any value but zero
  std::span<const std::uint8_t> payload;
};

/// Status: ok; not_supported (a fragment, "LC03": messages above 64 kB are not put together, because that
/// needs memory that a stranger chooses); malformed (anything else). `message` changes only with ok. Reads
/// nothing outside the datagram; cost: linear in the channel's length.
[[nodiscard]] Status parse_lc02(std::span<const std::uint8_t> datagram, Lc02Message& message) noexcept;

}  // namespace sortie::drivers
