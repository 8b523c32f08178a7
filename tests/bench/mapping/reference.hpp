// SPDX-License-Identifier: BSD-3-Clause
// What a map with fine voxels and no budget would say, from scratch: the sweep's measure of error.
#pragma once

#include "tests/bench/mapping/batch_twin.hpp"
#include "tests/bench/mapping/streams.hpp"

namespace sortie::bench {

/// Settings that both policies and all cells of a sweep share.
struct SweepRadii {
  double grow_m{0.2};
  double normals_m{0.3};
  double map_m{15.0};
  double half_height_m{5.5};
  double most_angle_rad{0.07};
  double most_curvature{0.05};
};

/// Some of the fine voxels' means, and what is known of them.
struct Reference {
  std::vector<TwinPoint> samples;
  std::vector<std::uint32_t> clusters;
  std::vector<std::uint32_t> surfaces;
  std::vector<TwinNormal> normals;
};

/// From all points of the stream that lie within the local map's reach, in voxels of 5 cm, around the last
/// sensor.
Reference reference_of(const MappingStream& stream, const SweepRadii& radii);

}  // namespace sortie::bench
