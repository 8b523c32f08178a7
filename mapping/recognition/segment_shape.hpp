// SPDX-License-Identifier: BSD-3-Clause
// From a segment's voxels to its descriptor in two visits: the first one gives sums up to the second degree
// (SegmentMoments), hence the middle, the axes and the spread; the second one counts by these.
#pragma once

#include <cstdint>

#include "mapping/recognition/segment_descriptor.hpp"
#include "mapping/segments/segment_features.hpp"

namespace sortie::mapping {

/// Spread that is added to every other one, m, in squares: what is thinner is as thin as this. Below it the
/// thickness of a wall is noise, and so are the direction and the skew of what has no more extent.
inline constexpr double kLeastSpread_m = 0.03125;

/// What the second visit measures voxels by, and what the first one has already said. Lengths are steps of
/// 1/256 of a cell, relative to where the moments are; z of the grid points up.
struct SegmentFrame {
  std::int32_t middle[3]{};  ///< mean in whole steps, so that moving all voxels moves it and nothing else
  double rest[3]{};          ///< mean - middle, in [-0.5, 0.5]
  double axis[2][3]{};       ///< the two longer principal axes, divided by the spread along them
  double per_height{};       ///< 1 / spread upwards
  double per_radius{};       ///< 1 / root mean square of the distance from the upright through the mean
  double upright[2]{};       ///< |vertical part| of the axes, [0, 1]
  double
      certain[2]{};  ///< 0: another spread is as large as the axis', its direction is chance; 1: it is clear
  std::uint8_t size[3]{};
  std::uint8_t fill{};
};

/// Frame of a segment; of none (count 0) all is 0. Cost: an eigenvalue problem and four logarithms, about
/// 0.4 us. No order of the voxels and no whole step that they are moved by changes a bit of it but `middle`.
SegmentFrame frame_of(const SegmentMoments& moments, double voxel_size_m);

/// Sums of the second visit: whole numbers, exact. A voxel beyond kMost spreads counts as if it were there,
/// so that 2^18 voxels fit, whatever they are. 88 bytes.
struct SegmentShape {
  static constexpr double kUnit = 1024.0;      ///< steps of a spread in the third moments
  static constexpr std::int32_t kMost = 8192;  ///< 8 spreads: its cube and 2^18 of these are 2^57
  static constexpr std::int32_t kBin = 256;    ///< share of a bin that a voxel has
  std::int64_t count{};
  std::int64_t cube[2]{};  ///< along the axes
  /// Each voxel is shared by the two bins whose middles it lies between, so that no bin has an edge. Heights:
  /// middles from -2 to 2 spreads about the mean. Distances: from 0 to 2 root mean squares. Beyond: the last.
  std::uint32_t height[SegmentDescriptor::kBins]{};
  std::uint32_t radius[SegmentDescriptor::kBins]{};

  void add(const SegmentFrame& frame, const std::int32_t (&at)[3]);
};

/// The descriptor from both visits; all 0 where one of them saw no voxel.
///
/// Of one voxel or many in one place: sizes 0, all heights in the two middle bins, all distances in the first
/// one. Axes whose spreads differ by less than one part in eight say nothing: they are chosen by rounding,
/// so upright and third moment are 0 and 128; from three in eight on they count in full. That is so of one of
/// two along a square or a ball, and of the second axis of a pole.
/// A third moment's sign says up or down, as far as its axis is upright. Of a level axis either end could
/// be the first: its third moment counts as positive.
///
/// Turned about the vertical the same voxels give the same steps but for rounding, at most one. A body that
/// is mapped anew after a turn does not: a wall along the grid has up to 1.41 times fewer voxels than one
/// across, so fill differs by up to 4, and where only some walls are along the grid, all other parts shift,
/// too.
SegmentDescriptor descriptor_of(const SegmentFrame& frame, const SegmentShape& shape);

}  // namespace sortie::mapping
