// SPDX-License-Identifier: BSD-3-Clause
// Grid, normals and segmenter in the order in which they depend on each other.
#pragma once

#include "mapping/grid/normals.hpp"
#include "mapping/grid/rolling_grid.hpp"
#include "mapping/segments/segmenter.hpp"
#include "rt/built_parts.hpp"

namespace sortie::mapping {

/// What one scan did to a local map.
struct LocalMapStep {
  RollingInsert inserted;
  NormalsStep normals;
  SegmenterStep segments;
};

/// Wires the parts of a local map, which somebody else owns. `normals` may be null: then nothing is computed
/// for them, and their memory need not exist.
template <SegmentationPolicy Policy>
class LocalMap {
 public:
  LocalMap(RollingGrid& grid, Normals* normals, Segmenter<Policy>& segmenter)
      : grid_(&grid), normals_(normals), segmenter_(&segmenter) {}

  /// A scan taken at `pose` (world from sensor), all the way to segments.
  LocalMapStep update(const rt::PointScan& scan, const RigidPose& pose, rt::Tick tick) {
    LocalMapStep step;
    step.inserted = insert(scan, pose, tick);
    step.normals = update_normals();
    step.segments = segment(tick);
    return step;
  }

  /// The three parts of update().
  RollingInsert insert(const rt::PointScan& scan, const RigidPose& pose, rt::Tick tick) {
    const EvictionHook hook{[](void* self, BlockIndex block) { static_cast<LocalMap*>(self)->forget(block); },
                            this};
    return grid_->insert(scan, pose, tick, hook);
  }
  NormalsStep update_normals() {
    NormalsStep step;
    for (const BlockChange& change : grid_->changes())
      segmenter_->mark(change.block, change.moved, change.drift);
    if (!rt::kBuilt<"normals"> || normals_ == nullptr) return step;
    step = normals_->update(*grid_);
    for (const BlockIndex block : normals_->turned_blocks()) segmenter_->mark(block, normals_->turned(block));
    return step;
  }
  SegmenterStep segment(rt::Tick tick) {
    return segmenter_->update(*grid_, static_cast<std::uint32_t>(tick));
  }

 private:
  void forget(BlockIndex block) {
    if (rt::kBuilt<"normals"> && normals_ != nullptr) normals_->forget(*grid_, block);
    segmenter_->forget(*grid_, block);
  }

  RollingGrid* grid_;
  Normals* normals_;
  Segmenter<Policy>* segmenter_;
};

}  // namespace sortie::mapping
