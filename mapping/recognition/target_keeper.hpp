// SPDX-License-Identifier: BSD-3-Clause
// What a run sees becomes targets: places on its map, hung on key frames along its way.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/rolling_grid.hpp"
#include "mapping/recognition/segment_watch.hpp"
#include "mapping/recognition/target_store.hpp"
#include "rt/keys.hpp"

namespace sortie::mapping {

/// A place in whole centimetres, at most 40 km from the origin along each axis; what is farther, or no
/// number, is taken as that far.
PlaceCm to_cm(const rt::Vector3& place_m);
/// Where the middle of a grid's window is, in the grid's world, m.
rt::Vector3 middle_of(const RollingGrid& grid);

struct TargetKeeperConfig {
  std::uint32_t robot{0};
  double key_frame_m{5.0};

  SORTIE_KEYS(c, key) {
    key("robot", c.robot, {0, 255, "", "number of this robot in its targets"});
    key("key_frame_m", c.key_frame_m, {0.5, 100, "m", "of way between two key frames that targets hang on"});
  }
};

/// A store and the key frames of one run. A key frame is where the middle of the local map was. When the
/// store's table of key frames is full, the last one takes what comes. No heap.
class TargetKeeper {
 public:
  TargetKeeper(const TargetKeeperConfig& config, const TargetStoreConfig& store, rt::Arena& arena);

  /// Segments with a version of `now_ns` become targets, or renew theirs. `T_map_world`: of the grid's world
  /// on the map that targets lie on; nearly level. What the store refuses it counts.
  void keep(std::span<const WatchedSegment> segments, const RollingGrid& grid, const RigidPose& T_map_world,
            rt::Nanoseconds now_ns);
  /// Goes on with the store's work; see TargetStore::run().
  void run(std::uint64_t& units) { static_cast<void>(store_.run(units)); }

  const TargetStore& store() const { return store_; }
  std::uint32_t key_frames() const { return key_frames_; }
  void archive(rt::Archive& archive);

 private:
  /// The newest key frame; there is one.
  const KeyFramePose& newest() const {
    return store_.key_frames().latest(static_cast<std::uint16_t>(key_frames_ - 1));
  }
  bool find_key_frame(const RollingGrid& grid, const RigidPose& T_map_world);

  TargetKeeperConfig config_;
  TargetStore store_;
  std::uint32_t key_frames_{};
};

}  // namespace sortie::mapping
