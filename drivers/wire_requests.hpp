// SPDX-License-Identifier: BSD-3-Clause
// Requests to the drive or the pilot of a run, as they come over the network. encode() and decode() are those
// of wire_fields.hpp; no heap. What the fields may be is for the receiver to judge.
#pragma once

#include <cstdint>

#include "drivers/wire_fields.hpp"
#include "rt/describe.hpp"

namespace sortie::drivers {

/// drive_request_t. Fields as in rt::DriveRequest.
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

/// fly_request_t. Fields as in rt::FlyRequest.
struct FlyRequestMessage {
  std::int64_t utime{};    ///< us UTC of the sender's clock
  std::int64_t session{};  ///< of the run that is meant
  std::int64_t sender{};   ///< any number
  std::int64_t counter{};  ///< above all that the run has taken
  double x_m{};
  double y_m{};
  double z_m{};
  double yaw_rad{};
  std::int32_t mode{};
  SORTIE_FIELDS(utime, session, sender, counter, x_m, y_m, z_m, yaw_rad, mode)
};
template <>
struct WireRules<FlyRequestMessage> : WireTagged {};

/// Bytes of the messages, fingerprint and tag included: always the same.
inline constexpr std::size_t kDriveRequestBytes = kLeastBytes<DriveRequestMessage>;
inline constexpr std::size_t kFlyRequestBytes = kLeastBytes<FlyRequestMessage>;

}  // namespace sortie::drivers
