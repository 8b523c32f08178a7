// SPDX-License-Identifier: BSD-3-Clause
// What a segment looks like: where it is, how large, and the seven features that eigenvalues give. All from
// sums that can be added up, in whole numbers, so that no order and no distance matters.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/rolling_grid.hpp"
#include "mapping/segments/labelling.hpp"
#include "rt/describe.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// Sums over voxels' means in whole 1/256 of a cell, relative to the corner of one block for all segments.
/// Exact: coordinates stay below 2^19, 2^18 voxels fit.
struct SegmentMoments {
  std::int64_t count{};
  std::int64_t sum[3]{};
  std::int64_t square[3]{};   ///< xx, yy, zz
  std::int64_t product[3]{};  ///< xy, xz, yz
  std::int32_t least[3]{};
  std::int32_t most[3]{};

  void add(const std::int32_t (&at)[3]);
};

/// Features of M. Weinmann et al. 2015 (l1 >= l2 >= l3 >= 0, divided by their sum). All finite and all in [0,
/// 1] but eigenentropy, which is in [0, ln 3]; of one voxel, or several in one place, all are 0.
struct SegmentFeatures {
  std::uint32_t voxels{};
  rt::Vector3 centroid_m;  ///< in the grid's frame
  rt::Vector3 least_m;     ///< corners of the box around the voxels' means
  rt::Vector3 most_m;
  double spread_m2[3]{};      ///< eigenvalues of the covariance, largest first
  double linearity{};         ///< (l1 - l2) / l1
  double planarity{};         ///< (l2 - l3) / l1
  double scattering{};        ///< l3 / l1
  double omnivariance{};      ///< (l1 l2 l3)^(1/3)
  double anisotropy{};        ///< (l1 - l3) / l1
  double eigenentropy{};      ///< -sum of l ln l
  double curvature_change{};  ///< l3 / (l1 + l2 + l3)
  SORTIE_FIELDS(voxels, centroid_m, least_m, most_m, spread_m2, linearity, planarity, scattering,
                omnivariance, anisotropy, eigenentropy, curvature_change)
};

/// Sums of every shown segment, one a slot of the labelling, over the voxels of its fragments. `moments`: at
/// least labelling.slots().size(). False, and nothing done, when it is shorter. One visit a voxel.
bool sum_segments(const RollingGrid& grid, const FragmentGraph& graph, const Labelling& labelling,
                  std::span<SegmentMoments> moments);

/// Features from sums that are relative to the corner of block `anchor`.
SegmentFeatures features_of(const SegmentMoments& moments, const BlockAt& anchor, double voxel_size_m);

}  // namespace sortie::mapping
