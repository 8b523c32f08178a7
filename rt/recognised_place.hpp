// SPDX-License-Identifier: BSD-3-Clause
// Where a robot recognises that it is on a known map, as it crosses rooms: output of the task, message.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// What a search for known segments, or for known height images, came to. Frames: known, that of the known
/// map; odom, the odometry's world.
struct RecognisedPlace {
  // Verdicts. Each from kFew on says why there is no place.
  static constexpr std::uint8_t kNone = 0;          ///< nothing was searched yet
  static constexpr std::uint8_t kRecognised = 1;    ///< segments agree, and a scan fits there
  static constexpr std::uint8_t kUnverified = 2;    ///< segments agree; no map, or no scan to hold against it
  static constexpr std::uint8_t kFew = 3;           ///< too few segments, or too few targets like them
  static constexpr std::uint8_t kInconsistent = 4;  ///< no set of segments that agree
  static constexpr std::uint8_t kBent = 5;          ///< sets that no pose lays: a mirror image, or chance
  static constexpr std::uint8_t kNarrow = 6;        ///< all of them in a row
  static constexpr std::uint8_t kAmbiguous = 7;     ///< another place has nearly as many
  static constexpr std::uint8_t kUndecided = 8;     ///< the units were spent
  static constexpr std::uint8_t kRefused = 9;       ///< segments agree, and a scan does not fit there
  /// Added to a verdict that height images came to, and no segments: a reader that does not know it takes
  /// such a place for none.
  static constexpr std::uint8_t kByImages = 16;

  Nanoseconds stamp_ns{};  ///< of the job that looked at the segments, run clock; 0: none yet
  std::uint8_t verdict{};
  double p_known_odom_m[3]{};  ///< T_known_odom of the best place; of one that is not recognised what it
                               ///< would be
  double q_known_odom[4]{1, 0, 0, 0};
  double covariance[16]{};   ///< without the scan, x, y, z, yaw of T_known_odom, by rows, m and rad
  std::uint32_t speaking{};  ///< segments that were asked for; by images, cells with structure
  std::uint32_t pairs{};     ///< correspondences with targets; by images, images that were compared
  std::uint32_t agree{};     ///< of them, in the best set; by images, what the best place scores, in cells
  std::uint32_t rival{};     ///< in the next one
  double rms_m{};            ///< of the best set's segments off their targets
  double spread_m{};         ///< standard deviation of their places, where it is least
  bool proved{};             ///< there is no larger set
  double share{};            ///< of the scan's returns where the map has seen something: on its surfaces
  double crossed{};          ///< of its rays: through surfaces
  SORTIE_FIELDS(stamp_ns, verdict, p_known_odom_m, q_known_odom, covariance, speaking, pairs, agree, rival,
                rms_m, spread_m, proved, share, crossed)
};

}  // namespace sortie::rt
