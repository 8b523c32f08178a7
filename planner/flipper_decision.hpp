// SPDX-License-Identifier: BSD-3-Clause
// What the flippers' policy is told, and what it says.
#pragma once

#include <cstdint>

#include "planner/arc_places.hpp"
#include "planner/missing_ground.hpp"
#include "rt/fields.hpp"
#include "rt/samples.hpp"
#include "rt/time.hpp"

namespace sortie::planner {

/// What the robot is and wants. Angles of flippers: up positive, in the order of FlipperSet.
struct FlipperInput {
  rt::Nanoseconds stamp_ns{};
  StandPose pose;
  double z_m{};  ///< of the body's origin
  double pitch_rad{};
  double roll_rad{};
  double measured_rad[rt::kFlippers]{};
  std::uint32_t broken{};  ///< bit f: flipper f does not move; it stays at its measured angle
  WantedArc arc;
  double mission_rad[rt::kFlippers]{};  ///< the mission's fixed posture, for when the policy cannot judge
  rt::Nanoseconds map_ns{};             ///< of the newest scan in the map
  rt::Nanoseconds attitude_ns{};        ///< of pitch and roll
  rt::Nanoseconds flippers_ns{};        ///< of the measured angles
  bool looked{};  ///< the cells named before were looked at since: no need to wait longer
};

/// What to do.
enum class FlipperVerdict : std::uint8_t {
  go,       ///< as wanted
  slow,     ///< the flippers are late: no faster than the limit, which may be 0
  look,     ///< stand still and look at the cells
  feel,     ///< stand still; the leading flippers go down until they touch
  creep,    ///< slowly, the next 0.1 m is safe
  stop,     ///< and say so
  mission,  ///< cannot judge: the mission's posture and speed, as without a policy
};

/// Why.
enum class FlipperReason : std::uint8_t {
  none,
  still,           ///< nothing is wanted
  flippers_late,   ///< not there yet
  missing_ground,  ///< no choice is safe for all that missing cells may hold
  unsafe_ground,   ///< no choice is safe, and nothing is missing
  map_disagrees,   ///< the map's ground is not where the vehicle stands
  stalled,         ///< told to go, it did not get on
  tilted,
  stale_map,
  lost_attitude,
  lost_flippers,
};

constexpr const char* to_string(FlipperReason reason) {
  switch (reason) {
    case FlipperReason::none:
      return "none";
    case FlipperReason::still:
      return "nothing is wanted";
    case FlipperReason::flippers_late:
      return "flippers are late";
    case FlipperReason::missing_ground:
      return "ground is missing";
    case FlipperReason::unsafe_ground:
      return "no posture is safe";
    case FlipperReason::map_disagrees:
      return "the map disagrees with the height";
    case FlipperReason::stalled:
      return "does not get on";
    case FlipperReason::tilted:
      return "tilted";
    case FlipperReason::stale_map:
      return "the map is stale: mission's posture";
    case FlipperReason::lost_attitude:
      return "pitch and roll are lost: mission's posture";
    case FlipperReason::lost_flippers:
      return "flippers do not say where they are: mission's posture";
  }
  return "unknown reason";
}

/// What is asked of the flippers and the drive.
struct FlipperDecision {
  rt::Nanoseconds stamp_ns{};
  double angle_rad[rt::kFlippers]{};
  double share{};            ///< of the wanted speed and turn, 0 to 1
  double speed_limit_m_s{};  ///< that share of the wanted speed's size
  FlipperVerdict verdict{FlipperVerdict::stop};
  FlipperReason reason{FlipperReason::none};
  double probability{};  ///< of falling short of a limit (FlipperLimits), with the angles asked for; 1 if not
                         ///< judged
  double margin_m{};     ///< least margin expected along the arc
  rt::FixedVector<CellIndex, MissingGround::kMostNamed> missing;  ///< where to look, nearest first
  std::uint32_t tried{};                                          ///< choices that were judged
  std::uint32_t units{};                                          ///< of work
};

/// How often each way out was begun, since start.
struct FlipperCounters {
  std::uint32_t late{}, looked{}, felt{}, crept{}, stopped{}, fell_back{};
  SORTIE_FIELDS(late, looked, felt, crept, stopped, fell_back)
};

}  // namespace sortie::planner
