// SPDX-License-Identifier: BSD-3-Clause
// A published descriptor of places, made again: SOLiD, from its paper's idea and its settings.
#pragma once

#include <vector>

#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::bench {

/// What of a place counts. By itself as published for a lidar on a road.
struct SolidConfig {
  double least_m{3.0};    ///< returns nearer than that are the robot's own
  double most_m{80.0};    ///< a range bin is a fortieth of it
  double thinned_m{0.4};  ///< to one return a cube of this edge; 0: all
};

/// A spatially organized and lightweight global descriptor (H. Kim et al., Narrowing your FOV with SOLiD,
/// RA-L 2024): of a histogram of returns by range and elevation, each elevation counts by how many returns
/// it has; what is left by range stays as it is when the sensor turns.
struct SolidVector {
  static constexpr int kRanges = 40;
  static constexpr int kElevations = 32;
  double range[kRanges]{};
};

/// Of returns in the sensor's frame, m. Elevations from -25 to 22.5 degrees; what is above or below is left
/// out, and what is farther than the farthest bin is in it, as published.
SolidVector solid_vector(const std::vector<rt::Vector3>& returns, const SolidConfig& config);

/// 1 - cosine of the two, 0 to 1; 1 where one has no returns.
double solid_distance(const SolidVector& a, const SolidVector& b);

}  // namespace sortie::bench
