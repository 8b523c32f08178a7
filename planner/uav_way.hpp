// SPDX-License-Identifier: BSD-3-Clause
// What a pilot asks of whoever plans its ways, and what it is answered.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/rotation.hpp"
#include "rt/time.hpp"

namespace sortie::planner {

/// A place to fly to.
struct UavGoal {
  rt::Vector3 p_m;
  double yaw_rad{};
  rt::Nanoseconds wait_ns{};  ///< so long it stays there before the mission goes on
  SORTIE_FIELDS(p_m, yaw_rad, wait_ns)
};

/// A question for a way, by number.
struct WayQuestion {
  std::uint32_t number{};  ///< from 1; 0: nothing was asked yet
  double from_m[3]{};
  double to_m[3]{};
  SORTIE_FIELDS(number, from_m, to_m)
};

/// The answer, as far as it is known.
struct UavWay {
  static constexpr std::uint32_t kMostPoints = 64;
  std::uint32_t number{};   ///< of the question
  std::uint32_t state{};    ///< planner::PathState
  std::uint32_t blocked{};  ///< 1: it was good, and the map has changed
  std::uint32_t whole{};    ///< 1: its last point is the goal; else ask again from there
  std::uint32_t points{};   ///< 0 until there is a way
  double length_m{};
  std::uint32_t map_version{};
  std::uint32_t boxes{};  ///< of the map, known so far
  double x_m[kMostPoints]{};
  double y_m[kMostPoints]{};
  double z_m[kMostPoints]{};
  SORTIE_FIELDS(number, state, blocked, whole, points, length_m, map_version, boxes, x_m, y_m, z_m)

  void set_point(std::uint32_t i, const rt::Vector3& p_m) {
    x_m[i] = p_m.x;
    y_m[i] = p_m.y;
    z_m[i] = p_m.z;
  }
};

}  // namespace sortie::planner
