// SPDX-License-Identifier: BSD-3-Clause
// A local map whose segmenter is stopped wherever a budget may stop it, while blocks come and go, pools run
// full and the state moves from one map to the next, beside twins that know nothing of all that.
#pragma once

#include <algorithm>
#include <memory>
#include <set>
#include <string>

#include "tests/mapping/random_worlds.hpp"

namespace sortie::tests {

/// What runs over sliced worlds met, and the first fault, with the seed of its world.
struct SliceVerdict {
  std::string fault;
  std::uint64_t steps{};
  std::uint64_t compared{};     ///< partitions with brute force
  std::uint64_t full{};         ///< times that all was done and a pool had no room
  std::uint64_t healed{};       ///< times that it was current again after that
  std::uint64_t interrupted{};  ///< labellings under way when a scan came
  std::uint64_t apart_left{};   ///< nodes that left when they were to be looked at
  std::uint64_t resumed{};
  std::uint64_t resumed_labelling{};  ///< those with a labelling under way
};

/// Bytes of a map's grid and segments; empty where that failed.
template <class Map>
std::vector<std::uint8_t> slice_bytes(Map& map) {
  const auto pass = [&map](rt::Archive& archive) {
    map.owned.grid.archive(archive);
    map.segments.segmenter.archive(archive, map.owned.grid);
    return archive.status() == Status::ok;
  };
  rt::Archive measure = rt::Archive::measuring();
  if (!pass(measure)) return {};
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  return pass(write) ? bytes : std::vector<std::uint8_t>{};
}

/// One world of a few blocks; a step is a scan, a slice of the segmenter's work, or a move to another map.
template <class Policy>
class SlicedWorld {
 public:
  using Map = OwnedMap<Policy>;

  SlicedWorld(std::uint32_t seed, const Policy& policy, SliceVerdict& verdict)
      : seed_(seed), policy_(policy), verdict_(verdict), random_(seed) {
    grid_.min_range_m = 0;
    grid_.radius_m = random_.between(0.45, 1.2);
    grid_.half_height_m = 0.45;
    grid_.min_points = 1 + random_.below(2);
    grid_.mean_window = random_.below(2) == 0 ? 65535 : 1 + random_.below(4);
    grid_.forget_ticks = random_.below(2) == 0 ? 0 : 2 + random_.below(20);
    grid_.evict_blocks = random_.below(3) == 0 ? 1 + random_.below(4) : 0;
    grid_.evict_farthest = random_.below(2) == 0;
    config_.radius_m = grid_.voxel_size_m * random_.between(0.7, 4.0);
    config_.min_voxels = 1;
    sizes_.blocks = 4 + random_.below(45);
    sizes_.voxels = 4 * (4 + random_.below(60));
    sizes_.nodes = random_.below(2) == 0 ? 1 + random_.below(20) : 256;
    sizes_.slots = random_.below(2) == 0 ? 1 + random_.below(6) : 256;
    sizes_.events = random_.below(4) == 0 ? 2 * random_.below(5) : 512;
    sizes_.points = 64;
    scans_ = 1 + random_.below(60);
    if (random_.below(2) == 0) {
      // One that crumbles: blocks that held large components together are forgotten while few edges are
      // known.
      grid_.radius_m = 1.2;
      grid_.min_points = 1;
      grid_.forget_ticks = 1 + random_.below(3);
      config_.radius_m = grid_.voxel_size_m * random_.between(2.0, 4.0);
      sizes_.blocks = 48;
      sizes_.voxels = 512;
      scans_ = 1 + random_.below(8);
      slow_ = true;
    }
    next_map();
  }

  /// Goes on until `steps` are done or something is wrong.
  void run(std::uint32_t steps) {
    for (step_ = 0; step_ < steps && verdict_.fault.empty(); ++step_, ++verdict_.steps) {
      const std::uint32_t kind = random_.below(100);
      // What a budget separates and a scan may come between: there the scan comes more often.
      const mapping::Labelling& labelling = map_->segmenter().labelling();
      const bool between = labelling.apart() != mapping::kNoNode;
      if (kind < (between ? 70 : scans_)) {
        scan();
      } else if (kind < (labelling.running() ? 92 : 98)) {
        slice();
      } else {
        resume();
      }
      if (step_ % 8 != 0) continue;
      if (const char* what = map_->segmenter().broken(map_->grid()); what != nullptr) fail(what);
    }
  }

 private:
  void fail(const std::string& what) {
    if (verdict_.fault.empty())
      verdict_.fault = what + ", seed " + std::to_string(seed_) + ", step " + std::to_string(step_);
  }
  void next_map() {
    config_.units = 1 + random_.below(slow_ ? 12 : random_.below(2) == 0 ? 40 : 1000);
    map_ = std::make_unique<Map>(grid_, config_, sizes_, policy_);
  }

  void scan() {
    const mapping::Labelling& labelling = map_->segmenter().labelling();
    const mapping::NodeIndex apart = labelling.apart();
    if (labelling.running()) ++verdict_.interrupted;
    sensor_.x += random_.between(-0.2, 0.25);
    sensor_.y += random_.between(-0.2, 0.2);
    if (random_.below(apart != mapping::kNoNode ? 4 : 40) == 0) sensor_.x += random_.between(-0.8, 0.8);
    std::vector<rt::ScanPoint> points(random_.below(3) == 0 ? 0 : random_.below(24));
    for (rt::ScanPoint& p : points) {
      p.x_m = random_.coordinate(-0.8, 0.8);
      p.y_m = random_.below(2) == 0 ? random_.coordinate(-0.8, 0.8) : random_.coordinate(-0.1, 0.1);
      p.z_m = random_.coordinate(-0.15, 0.15);
    }
    (void)map_->map.insert(scan_over(points), {sensor_, {}}, ++tick_);
    (void)map_->map.update_normals();
    if (apart != mapping::kNoNode && map_->segmenter().graph()[apart].block == mapping::kNoBlock)
      ++verdict_.apart_left;
  }

  void slice() {
    const mapping::LabellingCounts before = map_->segmenter().labelling().counts();
    const mapping::SegmenterStep step = map_->map.segment(tick_);
    if (step.units >= config_.units + mapping::Segmenter<Policy>::kBlockUnits) fail("a budget is not kept");
    follow_events(before);
    if (step.current && !step.done) fail("current, but not done");
    if (step.done) compare(step);
  }

  /// A reader that takes events in their order knows which ids live; and no id is ever born twice.
  void follow_events(const mapping::LabellingCounts& before) {
    const mapping::Labelling& labelling = map_->segmenter().labelling();
    const mapping::LabellingCounts& counts = labelling.counts();
    std::set<mapping::SegmentId> there;
    for (const mapping::SegmentSlot& slot : labelling.slots())
      if (slot.voxels[labelling.shown()] > 0 && !there.insert(slot.id).second) fail("two slots with one id");
    if (there.count(mapping::kNoSegment) != 0) fail("a segment without id");
    if (counts.born - counts.renamed - counts.gone != there.size()) fail("counters lost a segment");
    if (counts.labellings == before.labellings + 1 && counts.events_lost == before.events_lost) {
      for (const mapping::SegmentEvent& event : labelling.events()) {
        const bool born = event.change == mapping::SegmentChange::born;
        if (born && event.id <= newest_) fail("an id came again");
        if (born ? !live_.insert(event.id).second : live_.erase(event.id) == 0) fail("an event out of order");
        if (born) newest_ = event.id;
      }
      if (live_ != there) fail("events do not lead to the segments that live");
    } else if (counts.labellings == before.labellings) {
      if (live_ != there) fail("segments changed without a labelling");
    }
    live_ = there;
    if (!live_.empty()) newest_ = std::max(newest_, *live_.rbegin());
  }

  /// With nothing left to do: the partition of brute force, or a pool without room and nothing merged.
  void compare(const mapping::SegmenterStep& step) {
    const mapping::RollingGrid& grid = map_->grid();
    const mapping::Segmenter<Policy>& segmenter = map_->segmenter();
    std::vector<TwinVoxel> cores;
    std::vector<typename Policy::Voxel> held;
    for (const TwinVoxel& v : twin_voxels(grid)) {
      const mapping::Block& block = grid.block(v.block);
      const typename Policy::Voxel voxel = policy_.load(grid, block.slot(block.rank(v.cell)));
      if (!policy_.core(voxel)) continue;
      cores.push_back(v);
      held.push_back(voxel);
    }
    const double radius = config_.radius_m / grid_.voxel_size_m;
    const std::vector<std::size_t> twin = twin_components(cores.size(), [&](std::size_t a, std::size_t b) {
      return twin_near(cores[a], cores[b], radius) && policy_.join(held[a], held[b]);
    });
    std::vector<std::uint32_t> ids;
    std::map<std::uint32_t, std::size_t> component_of;
    std::uint32_t without = 0;
    for (std::size_t i = 0; i < cores.size(); ++i) {
      ids.push_back(segmenter.segment_of(grid, cores[i].block, cores[i].cell));
      if (ids[i] == mapping::kNoSegment) {
        ++without;
      } else if (component_of.emplace(ids[i], twin[i]).first->second != twin[i]) {
        fail("a segment of two components");
      }
    }
    ++verdict_.compared;
    if (step.current) {
      if (without > 0 || !same_partition(twin, ids)) fail("current, but another partition");
      if (was_full_) ++verdict_.healed;
      was_full_ = false;
      return;
    }
    const bool nodes = step.wanting > 0 && segmenter.graph().in_use() == sizes_.nodes;
    const bool slots = segmenter.labelling().nameless() > 0 && live_.size() == sizes_.slots;
    if (!nodes && !slots) fail("not current, and yet there is room");
    if (!was_full_) ++verdict_.full;
    was_full_ = true;
  }

  /// The state goes on in another map, with another budget.
  void resume() {
    const std::unique_ptr<Map> old = std::move(map_);
    ++verdict_.resumed;
    const bool running = old->segmenter().labelling().running();
    if (running) ++verdict_.resumed_labelling;
    const std::vector<std::uint8_t> bytes = slice_bytes(*old);
    next_map();
    rt::Archive read = rt::Archive::reading(bytes);
    map_->owned.grid.archive(read);
    map_->segments.segmenter.archive(read, map_->owned.grid);
    if (bytes.empty() || read.status() != Status::ok) return fail("a state that cannot be read");
    // A labelling under way held nodes back; it begins anew, and they are free.
    if (!running && slice_bytes(*map_) != bytes) fail("a state that is another one when read");
    if (const char* what = map_->segmenter().broken(map_->grid()); what != nullptr) fail(what);
  }

  std::uint32_t seed_;
  Policy policy_;
  SliceVerdict& verdict_;
  WorldRandom random_;
  mapping::RollingGridConfig grid_;
  mapping::SegmenterConfig config_;
  MapSizes sizes_;
  std::uint32_t scans_{};  ///< of 100 steps
  bool slow_{};            ///< many slices for a labelling
  std::unique_ptr<Map> map_;
  rt::Vector3 sensor_;
  std::uint32_t tick_{};
  std::uint32_t step_{};
  bool was_full_{};
  std::set<mapping::SegmentId> live_;
  mapping::SegmentId newest_{};
};

/// Worlds `first` .. `first` + `worlds` - 1; every fourth one is of smooth surfaces.
inline SliceVerdict sliced_worlds(std::uint32_t first, std::uint32_t worlds, std::uint32_t steps) {
  SliceVerdict verdict;
  for (std::uint32_t i = 0; i < worlds && verdict.fault.empty(); ++i) {
    if (i % 4 == 3) {
      SlicedWorld<mapping::SmoothnessPolicy>(first + i, mapping::SmoothnessPolicy(0.6, 0.33), verdict)
          .run(steps);
    } else {
      SlicedWorld<mapping::EuclideanPolicy>(first + i, {}, verdict).run(steps);
    }
  }
  return verdict;
}

}  // namespace sortie::tests
