// SPDX-License-Identifier: BSD-3-Clause
// A published way to recognise places, made again: binary features on a density image of a local map.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::bench {

/// A corner of the image and what is about it.
struct DensityFeature {
  double x{}, y{};  ///< in pixels, in the local map's frame
  std::uint64_t bits[4]{};
};

/// Features of a local map's density seen from above (S. Gupta et al., Effectively Detecting Loop Closures
/// using Point Cloud Density Maps, ICRA 2024): how many of the `places` (m) are in a column of `pixel_m`,
/// from 0 to 255, nothing below a twentieth of that. In it the 500 corners (FAST, threshold 35) that Harris'
/// measure says most of, turned by their centroid, and 256 comparisons of smoothed pixels about each
/// (E. Rublee et al., ORB, ICCV 2011; pairs are drawn, not learned). Beyond the image there is nothing, and
/// corners at its border count, too. Those that look like another one of the same map (35 bits) are left out.
std::vector<DensityFeature> density_features(const std::vector<rt::Vector3>& places, double pixel_m);

/// How many of the features' nearest others (50 bits at most) agree on a turn and a move, to 3 pixels, by
/// drawn pairs of them.
std::uint32_t agreeing_features(const std::vector<DensityFeature>& known,
                                const std::vector<DensityFeature>& asked);

}  // namespace sortie::bench
