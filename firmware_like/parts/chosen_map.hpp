// SPDX-License-Identifier: BSD-3-Clause
// A local map with the parts that a profile asks for, and memory for no others.
#pragma once

#include <optional>

#include "firmware_like/runtime/vehicle.hpp"
#include "mapping/grid/normals.hpp"
#include "mapping/segments/local_map.hpp"
#include "rt/arena.hpp"
#include "rt/built_parts.hpp"
#include "rt/keys.hpp"

namespace sortie::firmware {

/// How voxels become segments.
enum class SegmentsBy : std::uint8_t { off, euclidean, smoothness };

/// Settings and sizes of a local map.
struct ChosenMapConfig {
  mapping::RollingGridConfig grid;
  mapping::NormalsConfig normals;
  mapping::SegmenterConfig segments;
  SegmentsBy by{SegmentsBy::off};
  double most_angle_rad{0.07};  ///< of SmoothnessPolicy
  double most_curvature{0.05};  ///< of SmoothnessPolicy
  std::uint32_t voxels{};       ///< pools: a multiple of 4
  std::uint32_t blocks{};
  std::uint32_t most_segments{};
  std::uint32_t scan_points{};  ///< of the longest scan

  /// All but the grid's, which the defaults of others follow from, and the longest scan.
  SORTIE_KEYS(c, key) {
    key("segments", c.by,
        {"what makes voxels a segment",
         {{"off", SegmentsBy::off},
          {"euclidean", SegmentsBy::euclidean},
          {"smoothness", SegmentsBy::smoothness}}});
    mapping::SegmenterConfig::keys(c.segments, key);
    key("limits.segments", c.most_segments,
        {1, 65534, "segments", "pool of the ids that are in use at a time"});
    mapping::NormalsConfig::keys(c.normals, key);
    key("most_angle_deg", c.most_angle_rad,
        {0.1, 60, rt::kDegInRad, "between normals of neighbours in one segment"});
    key("most_curvature", c.most_curvature, {0, 1.0 / 3, "", "of a voxel that a segment grows from"});
    key("limits.voxels", c.voxels, {4, 262'136, "voxels", "pool of the map; whole fours of it", rt::kKnob});
    key("limits.blocks", c.blocks,
        {0, 65'534, "blocks", "pool of the map's blocks of 4 x 4 x 4 voxels; 0: one for 4 voxels"});
  }
};

/// What the segmenter shows of itself as a whole.
struct SegmentSummary {
  std::uint32_t segments{};
  std::uint32_t voxels{};   ///< in them; of smoothness, the flat ones
  std::uint32_t largest{};  ///< voxels of the largest one
  std::uint32_t backlog{};  ///< blocks that wait to be looked at
  bool current{true};       ///< what is shown is the map's exact partition now; never with a full pool
  mapping::SegmentEventCounts lives;
  std::uint64_t digest{};  ///< sum over the segments' ids and sizes, in no order
  SORTIE_FIELDS(segments, voxels, largest, backlog, current, lives, digest)
};

/// Grid, normals where a policy needs them, segmenter. No heap after construction.
class ChosenMap {
 public:
  /// Memory comes from `arena`; without enough of it nothing is ever taken.
  ChosenMap(const ChosenMapConfig& config, rt::Arena& arena);
  ChosenMap(const ChosenMap&) = delete;
  ChosenMap& operator=(const ChosenMap&) = delete;

  /// A scan taken at `pose`, as far as voxels and normals; segment() comes after it.
  mapping::RollingInsert insert(const rt::PointScan& scan, const mapping::RigidPose& pose, rt::Tick tick);
  /// A part of the segmenter's work: config.segments.units of it. Call it until done().
  void segment(rt::Tick tick);
  /// Nothing is left to do until the next scan. What is shown may still lack what a full pool had no room
  /// for: summary() says whether it is current.
  bool done() const { return done_; }
  /// Of the newest call of segment() that finished a labelling: O(most_segments).
  SegmentSummary summary() const;

  mapping::RollingGrid& grid() { return grid_; }
  const mapping::RollingGrid& grid() const { return grid_; }
  bool has_normals() const { return normals_.has_value(); }
  /// Null without segments.
  const mapping::Labelling* labelling() const;
  const mapping::FragmentGraph* graph() const;
  std::uint32_t most_segments() const { return config_.most_segments; }
  std::uint64_t fragment_capacity() const { return fragment_capacity_; }
  /// Chain over the changes of every scan so far: voxels and normals that changed, segments that came and
  /// went. Within a scan in no order.
  std::uint64_t change_digest() const { return change_digest_; }
  /// Blocks whose normals wait.
  std::uint32_t normals_backlog() const { return normals_backlog_; }
  /// Events of labellings that nobody could see, because the next one was finished in the same call.
  std::uint64_t events_unseen() const { return events_unseen_; }

  /// Calls `put(const VoxelOnMap&)` for every active voxel. Not for the real-time path.
  template <class Put>
  void for_each_voxel(Put put) const {
    for (std::uint32_t i = 0; i < grid_.block_numbers(); ++i) {
      const auto index = static_cast<mapping::BlockIndex>(i);
      const mapping::Block& block = grid_.block(index);
      if (!block.in_use()) continue;
      for (std::uint64_t cells = block.active; cells != 0; cells = mapping::without_lowest(cells))
        put(voxel(index, mapping::lowest(cells)));
    }
  }

  /// Grid, segments and their ids to bytes and back.
  void archive(rt::Archive& archive);

 private:
  // A build of one scene has one kind of segmenter at most.
  static constexpr bool kHasSmooth = rt::kBuilt<"normals">;
  static constexpr bool kHasEuclidean = rt::kBuilt<"segments"> && (*rt::kOnlyScene == '\0' || !kHasSmooth);
  // False: there is no segmenter.
  template <class Self, class Use>
  static bool with_segmenter(Self& self, Use use) {
    if constexpr (kHasEuclidean) {
      if (self.euclidean_) return use(*self.euclidean_), true;
    }
    if constexpr (kHasSmooth) {
      if (self.smooth_) return use(*self.smooth_), true;
    }
    return false;
  }
  VoxelOnMap voxel(mapping::BlockIndex block, unsigned cell) const;
  void digest_changes();
  void digest_events();

  ChosenMapConfig config_;
  mapping::RollingGrid grid_;
  std::optional<mapping::Normals> normals_;
  std::optional<mapping::Segmenter<mapping::EuclideanPolicy>> euclidean_;
  std::optional<mapping::Segmenter<mapping::SmoothnessPolicy>> smooth_;
  std::uint64_t fragment_capacity_{};
  bool current_{true};
  bool done_{true};
  std::uint32_t backlog_{};
  std::uint32_t normals_backlog_{};
  std::uint64_t labellings_{};
  std::uint64_t events_unseen_{};
  std::uint64_t change_digest_{};
};

}  // namespace sortie::firmware
