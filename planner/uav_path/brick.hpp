// SPDX-License-Identifier: BSD-3-Clause
// A brick is 4 x 4 x 4 voxels in one 64-bit word: bit x + 4 y + 16 z. Sets of its voxels are grown, split
// into connected parts and carried over to its neighbours with a few shifts.
#pragma once

#include <bit>
#include <cstdint>

namespace sortie::planner {

/// A set of a brick's voxels.
using BrickMask = std::uint64_t;

inline constexpr int kBrickEdge = 4;
inline constexpr BrickMask kWholeBrick = ~BrickMask{0};

/// Place of a voxel by its numbers; only x, y, z modulo 4 count.
struct Voxel3 {
  std::int32_t x{};
  std::int32_t y{};
  std::int32_t z{};
  friend constexpr bool operator==(const Voxel3&, const Voxel3&) = default;
};

/// The voxel's bit in its brick.
constexpr BrickMask brick_bit(const Voxel3& v) {
  return BrickMask{1} << ((v.x & 3) + 4 * (v.y & 3) + 16 * (v.z & 3));
}

/// The voxel of a bit of the brick with this lowest voxel.
constexpr Voxel3 brick_voxel(const Voxel3& corner, int bit) {
  return {corner.x + (bit & 3), corner.y + (bit >> 2 & 3), corner.z + (bit >> 4)};
}

namespace detail {
inline constexpr BrickMask kFirstX = 0x1111111111111111u;
inline constexpr BrickMask kLastX = kFirstX << 3;
inline constexpr BrickMask kFirstY = 0x000f000f000f000fu;
inline constexpr BrickMask kLastY = kFirstY << 12;
inline constexpr BrickMask kFirstZ = 0xffffu;

// Along one axis: grown by one voxel each way (offset 0), or what the growth reaches in the next brick.
constexpr BrickMask reach_x(BrickMask m, int offset) {
  if (offset == 0) return m | ((m & ~kLastX) << 1) | ((m & ~kFirstX) >> 1);
  return offset > 0 ? (m & kLastX) >> 3 : (m & kFirstX) << 3;
}
constexpr BrickMask reach_y(BrickMask m, int offset) {
  if (offset == 0) return m | ((m & ~kLastY) << 4) | ((m & ~kFirstY) >> 4);
  return offset > 0 ? (m & kLastY) >> 12 : (m & kFirstY) << 12;
}
constexpr BrickMask reach_z(BrickMask m, int offset) {
  if (offset == 0) return m | (m << 16) | (m >> 16);
  return offset > 0 ? m >> 48 : m << 48;
}
}  // namespace detail

/// The voxels of the brick at offset (dx, dy, dz), each -1, 0 or 1, that touch a voxel of `m` by face, edge
/// or corner; for (0, 0, 0) they include `m`.
constexpr BrickMask brick_reach(BrickMask m, int dx, int dy, int dz) {
  return detail::reach_x(detail::reach_y(detail::reach_z(m, dz), dy), dx);
}

/// The connected part (26 neighbours) of `free` that holds `seed`. At most 63 rounds.
constexpr BrickMask brick_part(BrickMask seed, BrickMask free) {
  BrickMask part = seed & free;
  for (;;) {
    const BrickMask grown = brick_reach(part, 0, 0, 0) & free;
    if (grown == part) return part;
    part = grown;
  }
}

/// The lowest voxel of a set that is not empty, as a set.
constexpr BrickMask lowest_voxel(BrickMask m) { return m & (~m + 1); }

/// Sums of the coordinates (0..3) of a set's voxels, and how many there are.
struct BrickSums {
  int x{};
  int y{};
  int z{};
  int count{};
};
constexpr BrickSums brick_sums(BrickMask m) {
  BrickSums s;
  s.count = std::popcount(m);
  for (int i = 1; i < kBrickEdge; ++i) {
    s.x += i * std::popcount(m & (detail::kFirstX << i));
    s.y += i * std::popcount(m & (detail::kFirstY << (4 * i)));
    s.z += i * std::popcount(m & (detail::kFirstZ << (16 * i)));
  }
  return s;
}

}  // namespace sortie::planner
