// SPDX-License-Identifier: BSD-3-Clause
// The plain values that cross rooms in flight. Frames and units as in rt/samples.hpp.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

inline constexpr std::uint32_t kMaxRotors = 8;

/// Bits of UavFix::flags. A field whose bit is not set is not there: who reads a sample asks the bit first,
/// on every way that leads to the field, also before asking whether it is finite.
enum UavFixFlags : std::uint32_t {
  kFixPosition = 1u,  ///< p_world_m is valid
  kFixYaw = 2u,       ///< yaw_rad is valid
};

/// Position and heading from a map matcher or the like. It may arrive long after its stamp.
struct UavFix {
  Nanoseconds stamp_ns{};  ///< moment that it is true of
  double p_world_m[3]{};
  double yaw_rad{};
  std::uint32_t flags{};
  SORTIE_FIELDS(stamp_ns, p_world_m, yaw_rad, flags)
};

/// Values of UavState::verdict, from good to bad.
enum class UavVerdict : std::uint32_t {
  starting,  ///< not levelled, or no position yet
  good,      ///< fixes come in and fit
  dead,      ///< dead reckoning: no fix for a while, the covariance grows
  lost,      ///< the position is not to be used any more; attitude and rate still are
};

/// Where a UAV is and how it moves.
struct UavState {
  Nanoseconds stamp_ns{};
  double p_world_m[3]{};
  double v_world_m_s[3]{};
  double q_world_body[4]{1, 0, 0, 0};
  double w_body_rad_s[3]{};      ///< bias removed
  double d_world_m_s2[3]{};      ///< acceleration that gravity and the expected thrust do not explain
  double position_sigma_m[3]{};  ///< standard deviations of the position
  UavVerdict verdict{};
  SORTIE_FIELDS(stamp_ns, p_world_m, v_world_m_s, q_world_body, w_body_rad_s, d_world_m_s2, position_sigma_m,
                verdict)
};

/// What somebody outside asks a UAV to do.
enum class FlyMode : std::uint32_t {
  go,       ///< to a place; from now on whoever asks is in control
  hover,    ///< stops where it can, and stays
  land,     ///< sinks where it is
  stop,     ///< rotors stand at once, also in the air: an emergency's last means
  release,  ///< hands control back to the mission
};

/// A request to fly.
struct FlyRequest {
  Nanoseconds stamp_ns{};  ///< receipt on the run's clock; 0 before
  std::int64_t counter{};  ///< of the sender: above all that were taken
  double p_world_m[3]{};   ///< where to, with FlyMode::go
  double yaw_rad{};
  std::uint32_t mode{};
  SORTIE_FIELDS(stamp_ns, counter, p_world_m, yaw_rad, mode)
};

/// Speeds that the rotors are asked for.
struct RotorCommand {
  Nanoseconds stamp_ns{};
  double speed_rad_s[kMaxRotors]{};
  std::uint32_t rotors{};
  std::uint32_t flags{};  ///< bit 0: enabled
  SORTIE_FIELDS(stamp_ns, speed_rad_s, rotors, flags)
};
/// A command that switches the rotors off: the vehicle stands (rt/command_outlet.hpp).
constexpr bool stops(const RotorCommand& command) { return (command.flags & 1u) == 0; }

}  // namespace sortie::rt
