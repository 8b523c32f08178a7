// SPDX-License-Identifier: BSD-3-Clause
// Requests to the drive of a run, as they come over the network. encode() and decode() are those of
// wire_fields.hpp; no heap.
#pragma once

#include <cstdint>

#include "drivers/wire_fields.hpp"
#include "rt/describe.hpp"

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
  SORTIE_FIELDS(utime, session, sender, counter, speed_m_s, turn_rad_s, mode, posture, flags)
};
template <>
struct WireRules<DriveRequestMessage> : WireTagged {};

/// Bytes of the message, fingerprint and tag included: always the same.
inline constexpr std::size_t kDriveRequestBytes = kLeastBytes<DriveRequestMessage>;

}  // namespace sortie::drivers
