// SPDX-License-Identifier: BSD-3-Clause
// What a voxel holds for its normal: the normal itself, and sums over its neighbours in whole numbers,
// relative to its own cell, so that what was added can be taken away again without a trace, at any distance
// from the origin. They lie apart, since segments read normals alone.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"

namespace sortie::mapping {

/// Direction of least spread about a voxel, in its grid's frame. 8 bytes.
struct SurfaceNormal {
  std::int16_t normal[3]{};   ///< unit vector in 1/32767; all 0: none
  std::uint16_t curvature{};  ///< smallest eigenvalue over their sum, in 1/65535 of its largest value 1/3

  SORTIE_FIELDS(normal, curvature)

  bool has_normal() const { return normal[0] != 0 || normal[1] != 0 || normal[2] != 0; }
};

/// Positions that go into the sums are whole 1/512 of a cell (0.2 mm for 0.1 m).
inline constexpr std::int32_t kContributionSteps = 512;

/// Three whole numbers in one, of less than 2^20 each: one addition adds all of them, and what each has from
/// the signs of those below it comes out again.
class PackedSum {
 public:
  static constexpr PackedSum of(std::int32_t x, std::int32_t y, std::int32_t z) {
    return PackedSum(std::int64_t{x} + (std::int64_t{y} << kBits) + (std::int64_t{z} << (2 * kBits)));
  }
  constexpr PackedSum() = default;
  constexpr PackedSum& operator+=(const PackedSum& other) {
    sum_ += other.sum_;
    return *this;
  }
  constexpr PackedSum& operator-=(const PackedSum& other) {
    sum_ -= other.sum_;
    return *this;
  }
  constexpr std::int32_t x() const { return low(sum_); }
  constexpr std::int32_t y() const { return low((sum_ - x()) >> kBits); }
  constexpr std::int32_t z() const {
    return static_cast<std::int32_t>((((sum_ - x()) >> kBits) - y()) >> kBits);
  }

  SORTIE_FIELDS(sum_)

 private:
  static constexpr int kBits = 21;
  explicit constexpr PackedSum(std::int64_t sum) : sum_(sum) {}
  static constexpr std::int32_t low(std::int64_t sum) {
    const std::int64_t part = sum & ((std::int64_t{1} << kBits) - 1);
    return static_cast<std::int32_t>(part >> (kBits - 1) != 0 ? part - (std::int64_t{1} << kBits) : part);
  }
  std::int64_t sum_{};
};

/// 40 bytes. A neighbour at most 4 cells away lies within 4.5 cells of the centre of the cell along each axis
/// and 400 of them fit: (4.5 * 512)^2 * 400 = 2.1e9, and 4.5 * 512 * 400 < 2^20.
struct NormalSums {
  std::uint32_t square[3]{};    ///< sums of xx, yy, zz
  std::int32_t product[3]{};    ///< sums of xy, xz, yz
  PackedSum sum;                ///< of x, y, z
  std::uint32_t contributed{};  ///< where this voxel was added: 9 bits x, y, z; kAdded
  std::uint16_t count{};        ///< neighbours in the sums, itself among them

  SORTIE_FIELDS(square, product, sum, contributed, count)

  static constexpr std::uint32_t kAdded = 0x80000000u;
  bool added() const { return (contributed & kAdded) != 0; }
  std::int32_t at(int axis) const { return static_cast<std::int32_t>((contributed >> (9 * axis)) & 511u); }
};
static_assert(sizeof(SurfaceNormal) == 8 && sizeof(NormalSums) == 40);

/// A normal as coarse as segments need it: components in 1/128, so within 0.4 degrees, and curvature in 1/64
/// of its largest value. Most of the small changes of a normal do not change this.
struct CoarseNormal {
  std::int16_t x;
  std::int16_t y;
  std::int16_t z;
  std::uint16_t level;

  bool operator==(const CoarseNormal&) const = default;
};

constexpr CoarseNormal coarse(const SurfaceNormal& n) {
  const auto round = [](std::int16_t v) { return static_cast<std::int16_t>((v + 128) >> 8); };
  return {round(n.normal[0]), round(n.normal[1]), round(n.normal[2]),
          static_cast<std::uint16_t>(n.curvature >> 10)};
}

}  // namespace sortie::mapping
