// SPDX-License-Identifier: BSD-3-Clause
// Requests to the drive of a run, as they come over the network.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/siphash.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// drive_request_t. Fields as in rt::DriveRequest; what they may be is for the receiver to judge.
struct DriveRequestMessage {
  std::int64_t utime{};    ///< us UTC of the sender's clock
  std::int64_t session{};  ///< of the run that is meant
  std::int64_t sender{};   ///< any number
  std::int64_t counter{};  ///< above all that the run has taken
  double speed_m_s{};
  double turn_rad_s{};
  std::int32_t mode{};
  std::int32_t posture{-1};
  std::int32_t flags{};
};

/// Bytes of the message, fingerprint and tag included: always the same.
inline constexpr std::size_t kDriveRequestBytes = 8 + 4 * 8 + 2 * 8 + 3 * 4 + 8;

/// A request with its tag; `key` null: tag 0. No heap. Decoding: `bad_checksum` for another type of message,
/// `malformed` for any other length, `disconnected` when `key` is given and the tag is not its; `request` is
/// then unchanged.
[[nodiscard]] Status encode(const DriveRequestMessage& request, const SipKey* key,
                            std::span<std::uint8_t> out, std::size_t& size) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, const SipKey* key,
                            DriveRequestMessage& request) noexcept;

}  // namespace sortie::drivers
