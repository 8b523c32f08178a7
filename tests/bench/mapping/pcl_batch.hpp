// SPDX-License-Identifier: BSD-3-Clause
// PCL's batch functions on the voxels that a local map holds.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// Voxels of the map relative to the sensor, the map's segment of each, and the points of the newest scan.
struct PclInput {
  std::vector<std::array<float, 3>> voxels;
  std::vector<std::uint32_t> segments;
  std::vector<std::array<float, 3>> scan;
  std::vector<std::array<float, 3>> normals;  ///< the map's; (0, 0, 0): none
};

/// Thread CPU time of each call.
struct PclTimes {
  Rounds filter_ms;  ///< VoxelGrid over the voxels of before and the new points
  Rounds tree_ms;
  Rounds normals_ms;   ///< NormalEstimation, 0.3 m
  Rounds segments_ms;  ///< EuclideanClusterExtraction, 0.2 m; or RegionGrowing, 4 deg, curvature 0.05
  Rounds whole_ms;
  std::vector<double>
      angles_deg;  ///< between the map's normals and PCL's on the current means, of flat voxels
};

bool has_pcl();

/// Runs them. Gives the voxels that lie in another cluster than the map's segments say (Euclidean only):
/// those outside the greatest common part of a cluster and a segment.
std::uint64_t run_pcl(const PclInput& input, bool smooth, PclTimes& times);

}  // namespace sortie::bench
