// SPDX-License-Identifier: BSD-3-Clause
// One voxel: sums anchored at its own cell, so that precision does not depend on where in the world it lies.
#pragma once

#include <cstdint>

#include "mapping/voxel_table.hpp"

namespace sortie::mapping {

/// Cell of the grid by whole numbers, each in [-2^20, 2^20).
struct Cell {
  static constexpr std::int32_t kLimit = 1 << 20;
  std::int32_t x{};
  std::int32_t y{};
  std::int32_t z{};

  /// 63-bit key: sorts by z, then y, then x.
  constexpr std::uint64_t key() const {
    const auto part = [](std::int32_t i) { return static_cast<std::uint64_t>(std::int64_t{i} + kLimit); };
    return part(x) | part(y) << 21 | part(z) << 42;
  }
  static constexpr Cell from_key(std::uint64_t key) {
    const auto part = [key](int shift) {
      return static_cast<std::int32_t>((key >> shift) & 0x1fffff) - kLimit;
    };
    return {part(0), part(21), part(42)};
  }
};

/// 32 bytes. Offsets within the cell are whole 1/65536 of its edge (1.5 um for 0.1 m): sums of them are
/// exact, so the result does not depend on the order of the points. From 65,535 points on a voxel takes no
/// more into its mean: by then one more point would move it by 1e-5 of a cell.
struct Voxel {
  static constexpr std::uint32_t kOffsetSteps = 1u << 16;
  static constexpr std::uint32_t kMostPoints = 65535;
  static constexpr std::uint32_t kUntouched = 0xfffffffeu;

  std::uint64_t key{};
  std::uint32_t offset_sum[3]{};
  std::uint32_t count{};
  std::uint32_t last_tick{};               ///< low 32 bits of the tick of its newest point
  std::uint32_t next_touched{kUntouched};  ///< list of the voxels that the present scan changes

  /// Adds a point given by its offset in steps, each below kOffsetSteps.
  void add(const std::uint32_t (&offset)[3], std::uint32_t tick) {
    last_tick = tick;
    if (count >= kMostPoints) return;
    for (int axis = 0; axis < 3; ++axis) offset_sum[axis] += offset[axis];
    ++count;
  }

  /// Digest of what the voxel holds (without the tick: the same points at other ticks make the same map).
  std::uint64_t digest() const {
    const auto pair = [](std::uint32_t low, std::uint32_t high) {
      return static_cast<std::uint64_t>(high) << 32 | low;
    };
    std::uint64_t h = mix64(key);
    h = mix64(h ^ pair(offset_sum[0], offset_sum[1]));
    return mix64(h + pair(offset_sum[2], count));
  }
};
static_assert(sizeof(Voxel) == 32);

}  // namespace sortie::mapping
