// SPDX-License-Identifier: BSD-3-Clause
// The peer: RRT-Connect of OMPL (Kuffner and LaValle 2000), with its simplification, among the same free
// voxels.
#pragma once

#include <string>

#include "planner/uav_path/flight_map.hpp"

namespace sortie::bench {

/// What the peer found.
struct PeerWay {
  bool found{};
  double ms{};  ///< CPU time, simplification included
  double length_m{};
};

/// Empty, or why there is no peer, with the cure.
std::string ompl_missing();
/// What it was told, for the report.
std::string ompl_settings();
/// One way between two free voxels; `seed` as a whole for OMPL's generators.
PeerWay ompl_way(const planner::FlightMap& map, const planner::Voxel3& start, const planner::Voxel3& goal);
/// Before the first way; OMPL takes a seed once a process.
void seed_ompl(std::uint32_t seed);

}  // namespace sortie::bench
