// SPDX-License-Identifier: BSD-3-Clause
// Correspondences with their truth: a drive through streets, and single ones of which most are wrong.
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/recognition/consistency_gate.hpp"

namespace sortie::bench {

/// Correspondences, and which of them are right.
struct SetScene {
  std::vector<mapping::SweptPair> pairs;
  std::vector<bool> right;
  std::uint32_t segments{};
  std::uint32_t targets{};
};

/// A map of 1,204 targets along 3.6 km of streets, a local map of 53 segments within 50 m, half of them on
/// the map: sizes of the published localisation (RA-L 2018, table III). 58 correspondences a segment.
SetScene street_scene(std::uint64_t seed);

/// `count` correspondences of as many segments and targets within 50 x 50 m, a share of them wrong; the
/// others are off by up to 10 cm along each axis.
SetScene outlier_scene(int count, double wrong, std::uint64_t seed);

}  // namespace sortie::bench
