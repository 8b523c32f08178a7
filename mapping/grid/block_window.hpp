// SPDX-License-Identifier: BSD-3-Clause
// Finds the block at a place: a table that wraps around, as large as the window that rolls with the robot. No
// hash, no probe, no tombstone: one look-up, whatever happened before.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "mapping/grid/block.hpp"

namespace sortie::mapping {

/// Table of block numbers in the caller's memory, all of the same power-of-two size along x and y and another
/// along z. Two blocks a whole window apart share an entry: the reader compares the key of what it finds.
class BlockWindow {
 public:
  /// Entries that a window of 2^bits_xy x 2^bits_xy x 2^bits_z blocks takes.
  static constexpr std::uint32_t entries_for(unsigned bits_xy, unsigned bits_z) {
    return std::uint32_t{1} << (2 * bits_xy + bits_z);
  }

  /// `table`: at least entries_for() entries.
  BlockWindow(std::span<BlockIndex> table, unsigned bits_xy, unsigned bits_z)
      : table_(table),
        bits_z_(bits_z),
        bits_y_(bits_xy + bits_z),
        mask_xy_((1u << bits_xy) - 1),
        mask_z_((1u << bits_z) - 1) {
    clear();
  }

  /// Entry of a place. A column along z lies together: one or two cache lines.
  std::uint32_t entry(const BlockAt& at) const {
    return (static_cast<std::uint32_t>(at.x) & mask_xy_) << bits_y_ |
           (static_cast<std::uint32_t>(at.y) & mask_xy_) << bits_z_ |
           (static_cast<std::uint32_t>(at.z) & mask_z_);
  }
  /// Entries of the 27 blocks around a place, in the order of directions.
  void around(const BlockAt& at, std::uint32_t (&entries)[kDirections]) const {
    const auto wrap = [](std::int32_t v, std::uint32_t mask) { return static_cast<std::uint32_t>(v) & mask; };
    int direction = 0;
    for (std::int32_t dz = -1; dz <= 1; ++dz) {
      const std::uint32_t z = wrap(at.z + dz, mask_z_);
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        const std::uint32_t yz = wrap(at.y + dy, mask_xy_) << bits_z_ | z;
        for (std::int32_t dx = -1; dx <= 1; ++dx)
          entries[direction++] = wrap(at.x + dx, mask_xy_) << bits_y_ | yz;
      }
    }
  }
  BlockIndex& operator[](std::uint32_t entry) { return table_[entry]; }
  BlockIndex operator[](std::uint32_t entry) const { return table_[entry]; }
  void prefetch(std::uint32_t entry) const { __builtin_prefetch(&table_[entry]); }
  void clear() { std::fill(table_.begin(), table_.end(), kNoBlock); }

 private:
  std::span<BlockIndex> table_;
  unsigned bits_z_;
  unsigned bits_y_;
  std::uint32_t mask_xy_;
  std::uint32_t mask_z_;
};

}  // namespace sortie::mapping
