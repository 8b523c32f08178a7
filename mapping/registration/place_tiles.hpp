// SPDX-License-Identifier: BSD-3-Clause
// Maps of bits that are looked at for 64 poses at once.
#pragma once

#include <cstdint>
#include <span>

namespace sortie::mapping {

/// Where a return lies from the sensor, whole voxels.
struct PlaceOffset {
  std::int16_t at[3]{};
};

/// Two bits of each voxel of a grid, for poses that stand `stride` voxels apart. Each kind lies in tiles of 8
/// x 8 poses, one every 4, so that the bits of any 4 x 4 poses side by side lie in one of them: one load, one
/// shift. Memory: about a byte a voxel, more for small grids.
class PlaceTiles {
 public:
  /// Voxels before the map's first one: bits of poses that stand outside of it.
  static constexpr std::int32_t kMargin = 8;
  static constexpr int kLanes = 64;  ///< poses of a block: 4 along each axis
  static constexpr int kKinds = 2;
  static constexpr int kMost = 124;  ///< returns that can be counted

  /// Where a return's bits begin for one turn of the scan, whatever the block.
  struct Look {
    std::uint32_t base{};    ///< of its class of voxels, words
    std::int16_t tile[3]{};  ///< of the first block; along z the pose itself
    std::uint8_t shift{};
  };

  /// 64-bit words for a grid of voxels, both kinds.
  static std::size_t words(const std::int32_t (&voxels)[3], std::int32_t stride);

  /// `words`: as many as words() says, for the largest grid. `stride`: a power of two, at most kMargin.
  PlaceTiles(std::span<std::uint64_t> words, std::int32_t stride) : words_(words), stride_(stride) {}

  /// Empty, for a grid. False: there is no room for it.
  bool begin(const std::int32_t (&voxels)[3]);
  /// Sets a bit of a voxel of the grid.
  void set(int kind, std::int32_t x, std::int32_t y, std::int32_t z);

  /// A return that lies `offset` from the sensor; the sensor of pose 0 stands at voxel kMargin.
  Look look(const PlaceOffset& offset) const;
  /// How many bits, of both kinds together, at most kMost returns lie on, for each of the 64 poses of a
  /// block; its first pose is 4 times `block`. Returns outside the grid count nothing. Eight loads a return.
  void count(std::span<const Look> looks, const std::int32_t (&block)[3],
             std::uint8_t (&counts)[kLanes]) const;

  /// The place in its block of a lane of count().
  static constexpr std::int32_t lane_x(int lane) { return lane & 3; }
  static constexpr std::int32_t lane_y(int lane) { return (lane >> 3) & 3; }
  static constexpr std::int32_t lane_z(int lane) { return ((lane >> 2) & 1) | ((lane >> 5) << 1); }

 private:
  void bits(const Look& look, const std::int32_t (&block)[3], std::uint64_t& near, std::uint64_t& on) const;

  std::span<std::uint64_t> words_;
  std::int32_t stride_;
  std::int32_t tiles_[2]{};  ///< along x and y
  std::int32_t high_{};      ///< poses along z
};

}  // namespace sortie::mapping
