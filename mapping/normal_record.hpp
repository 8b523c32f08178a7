// SPDX-License-Identifier: BSD-3-Clause
// What a voxel holds for its normal: sums over its neighbours in whole numbers, relative to its own cell, so
// that what was added can be taken away again without a trace, at any distance from the origin.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"

namespace sortie::mapping {

/// Positions that go into the sums are whole 1/512 of a cell (0.2 mm for 0.1 m).
inline constexpr std::int32_t kContributionSteps = 512;

/// 52 bytes. A neighbour at most 4 cells away lies within 4.5 cells of the centre of the cell along each axis
/// and 400 of them fit: (4.5 * 512)^2 * 400 = 2.1e9.
struct NormalRecord {
  std::uint32_t square[3]{};  ///< sums of xx, yy, zz
  std::int32_t product[3]{};  ///< sums of xy, xz, yz
  std::int32_t sum[3]{};      ///< sums of x, y, z
  std::uint32_t
      contributed{};          ///< where this voxel stood when it was added: 9 bits x, y, z; 0x80000000: added
  std::uint16_t count{};      ///< neighbours in the sums, itself among them
  std::uint16_t curvature{};  ///< smallest eigenvalue over their sum, in 1/65535 of its largest value 1/3
  std::int16_t normal[3]{};   ///< unit vector in 1/32767; all 0: none

  SORTIE_FIELDS(square, product, sum, contributed, count, curvature, normal)

  static constexpr std::uint32_t kAdded = 0x80000000u;
  bool added() const { return (contributed & kAdded) != 0; }
  std::int32_t at(int axis) const { return static_cast<std::int32_t>((contributed >> (9 * axis)) & 511u); }
  bool has_normal() const { return normal[0] != 0 || normal[1] != 0 || normal[2] != 0; }
};
static_assert(sizeof(NormalRecord) == 52);

/// A normal as coarse as segments need it: components in 1/128, so within 0.4 degrees, and curvature in 1/64
/// of its largest value. Most of the small changes of a normal do not change this.
struct CoarseNormal {
  std::int16_t x;
  std::int16_t y;
  std::int16_t z;
  std::uint16_t level;

  bool operator==(const CoarseNormal&) const = default;
};

constexpr CoarseNormal coarse(const std::int16_t (&normal)[3], std::uint16_t curvature) {
  const auto round = [](std::int16_t v) { return static_cast<std::int16_t>((v + 128) >> 8); };
  return {round(normal[0]), round(normal[1]), round(normal[2]), static_cast<std::uint16_t>(curvature >> 10)};
}

}  // namespace sortie::mapping
