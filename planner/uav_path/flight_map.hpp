// SPDX-License-Identifier: BSD-3-Clause
// Where a flying robot may be: the blocked voxels of a map, and those whose middle its body must stay away
// from.
#pragma once

#include <cstdint>
#include <span>

#include "planner/uav_path/brick.hpp"
#include "rt/archive.hpp"
#include "rt/keys.hpp"
#include "rt/rotation.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// Size of the map and of the robot.
struct FlightMapConfig {
  std::int32_t nx{};  ///< voxels, multiples of 4, at most 1024
  std::int32_t ny{};
  std::int32_t nz{};
  double voxel_m{0.2};
  rt::Vector3 origin_m;                   ///< lowest corner, world
  rt::Vector3 radii_m{0.35, 0.35, 0.15};  ///< of the ellipsoid that holds the robot; x and y equal
  bool unknown_is_blocked{true};          ///< voxels that nobody has spoken of

  /// The extent is written in metres, of which voxels are made; the robot's radii are parts of its airframe.
  SORTIE_KEYS(c, key) {
    key("voxel_m", c.voxel_m, {0.05, 2, "m", "edge of a voxel"});
    constexpr const char* kCorner = "lowest corner of the map";
    key("x_m", c.origin_m.x, {-4000, 4000, "m", kCorner});
    key("y_m", c.origin_m.y, {-4000, 4000, "m", kCorner});
    key("z_m", c.origin_m.z, {-4000, 4000, "m", kCorner});
  }
};

/// Two bits a voxel. A voxel is free when the robot can be anywhere in it, and move from it to any free
/// neighbour, without touching a blocked voxel or leaving the map: the ellipsoid at its middle keeps half a
/// voxel's diagonal from all of them. So every line through free voxels alone is safe. Memory: 16 bytes a
/// brick of 64 voxels plus one bit. No heap.
class FlightMap {
 public:
  /// `blocked` and `free` hold bricks() words each, `dirty` a bit a brick. Set-up only: judges up to some
  /// thousand positions of the robot exactly. usable() says whether sizes and memory fit.
  FlightMap(const FlightMapConfig& config, std::span<BrickMask> blocked, std::span<BrickMask> free,
            std::span<std::uint64_t> dirty);

  /// Words that `config` needs for each of the two sets, and for the dirty bits. 0 for sizes that are not
  /// usable.
  static std::uint32_t bricks_for(const FlightMapConfig& config);
  static std::uint32_t dirty_words_for(const FlightMapConfig& config) {
    return (bricks_for(config) + 63) / 64;
  }

  /// ok; out_of_range: a size, radius or the memory is not usable, or the robot is larger than 8 voxels'
  /// radius.
  Status usable() const { return usable_; }

  /// Says what is in a voxel. out_of_range outside of the map.
  Status set_blocked(const Voxel3& voxel, bool blocked);

  /// Works off what set_blocked() changed, at most `most_bricks` of the bricks near it. True when all is
  /// done. Until then is_free() of some voxels is older than the map. Cost: 10 us a brick at the most.
  bool refresh(std::uint32_t most_bricks);

  bool is_inside(const Voxel3& v) const {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < config_.nx && v.y < config_.ny && v.z < config_.nz;
  }
  bool is_blocked(const Voxel3& v) const {
    return !is_inside(v) || (blocked_[brick_of(v)] & brick_bit(v)) != 0;
  }
  bool is_free(const Voxel3& v) const { return is_inside(v) && (free_[brick_of(v)] & brick_bit(v)) != 0; }

  /// The free voxel nearest to a place of those more than `beyond_m` away, within `reach` voxels along each
  /// axis. False without one; `found` is then as before. Cost: (2 reach + 1)^3 looks.
  bool nearest_free(const rt::Vector3& from_m, double beyond_m, std::int32_t reach, Voxel3& found) const;

  /// Rises with each refresh() that had something to work in: plans made before may be worth a look.
  std::uint32_t version() const { return version_; }

  /// The bricks: free voxels of each for searches, blocked ones of one for exact checks.
  std::span<const BrickMask> free_bricks() const { return free_; }
  BrickMask blocked_brick(std::uint32_t brick) const { return blocked_[brick]; }
  std::uint32_t brick_of(const Voxel3& v) const {
    return static_cast<std::uint32_t>((v.x >> 2) + bx_ * ((v.y >> 2) + by_ * (v.z >> 2)));
  }
  /// Lowest voxel of a brick.
  Voxel3 corner_of(std::uint32_t brick) const {
    const auto b = static_cast<std::int32_t>(brick);
    return {4 * (b % bx_), 4 * (b / bx_ % by_), 4 * (b / (bx_ * by_))};
  }
  const FlightMapConfig& config() const { return config_; }

  /// Middle of a voxel, and the voxel of a point (which may lie outside), world.
  rt::Vector3 middle_m(const Voxel3& v) const;
  Voxel3 voxel_at(const rt::Vector3& p_world_m) const;

  /// State to bytes and back, into a map of the same configuration: 16 bytes a brick.
  void archive(rt::Archive& archive);

 private:
  static constexpr std::int32_t kMostReach = 8;
  static constexpr std::uint32_t kMostOffsets = 2500;
  struct Offset {
    std::int8_t x{};
    std::int8_t y{};
    std::int8_t z{};
  };
  void make_offsets();
  BrickMask free_voxels(std::uint32_t brick) const;

  FlightMapConfig config_;
  Status usable_{Status::ok};
  std::span<BrickMask> blocked_;
  std::span<BrickMask> free_;
  std::span<std::uint64_t> dirty_;
  std::int32_t bx_{};  ///< bricks along x
  std::int32_t by_{};
  std::int32_t reach_{};  ///< voxels, in any direction
  std::uint32_t offset_count_{};
  std::uint32_t hand_{};  ///< dirty word to look at next
  std::uint32_t version_{};
  Offset offsets_[kMostOffsets]{};
};

}  // namespace sortie::planner
