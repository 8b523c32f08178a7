// SPDX-License-Identifier: BSD-3-Clause
// The last word on a piece of way: the robot's ellipsoid, swept along the line, against every blocked voxel
// near it.
#pragma once

#include <cstdint>

#include "planner/uav_path/flight_map.hpp"

namespace sortie::planner {

/// What a check said.
struct SweptCheck {
  bool is_free{};           ///< a gap was proved to every blocked voxel and to the map's border
  std::uint32_t queries{};  ///< pairs that were judged
  std::uint32_t bricks{};   ///< that were looked at: those along the line, whatever the map's size
};

/// Judges the straight way from `a_m` to `b_m` (world). Exact to 1e-9 m, on the safe side: what cannot be
/// decided within the bounds of rt/convex counts as a collision, so does anything outside of the map. Cost:
/// 150 ns a blocked voxel, or whole blocked brick, whose box lies near the line, and some ns for each brick
/// along it; none for the others. `share` of the map's radii: less than 1 for a robot that stands nearer to
/// something than it would go.
SweptCheck check_swept(const FlightMap& map, const rt::Vector3& a_m, const rt::Vector3& b_m,
                       double share = 1.0);

}  // namespace sortie::planner
