// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/hall_visit.hpp"

#include <map>
#include <stdexcept>

#include "mapping/recognition/segment_describer.hpp"
#include "mapping/recognition/segment_watch.hpp"
#include "tests/bench/recognition/owned_sets.hpp"
#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;

constexpr rt::Nanoseconds kScan_ns = 400'000'000;
constexpr double kFloor_m = 0.15;
constexpr double kMostRange_m = 25.0;

const tests::MapSizes kSizes{65'534, 262'136, 65'534, 65'536, 2048, 4096};

RollingGridConfig grid_config() {
  RollingGridConfig config;
  config.max_range_m = kMostRange_m;
  return config;
}

/// A frame in another one: the way back.
RigidPose inverse(const RigidPose& pose) {
  const rt::Quaternion back{pose.q.w, -pose.q.x, -pose.q.y, -pose.q.z};
  return {-1.0 * rt::rotate(back, pose.p), back};
}

template <class Policy>
class VisitMap {
 public:
  explicit VisitMap(const RigidPose& map)
      : hall_map_(map),
        map_hall_(inverse(map)),
        owned_(grid_config(), SegmenterConfig{}, kSizes),
        memory_(std::size_t{1} << 20),
        arena_(memory_),
        describer_(kSizes.slots, kSizes.slots / 2, arena_),
        watch_(watch_config(), arena_) {
    if (arena_.refused() != 0) throw std::runtime_error("descriptors: no room for a visit");
  }

  void scan(const HallScan& scan, bool with_floor) {
    points_.clear();
    for (const rt::ScanPoint& p : scan.points) {
      const rt::Vector3 at = rt::rotate(
          scan.pose.q, {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)});
      if (with_floor || scan.pose.p.z + at.z >= kFloor_m) points_.push_back(p);
    }
    rt::PointScan view;
    view.header.points = static_cast<std::uint32_t>(points_.size());
    view.points = points_.data();
    const RigidPose pose{rt::rotate(map_hall_.q, scan.pose.p) + map_hall_.p,
                         rt::normalised(map_hall_.q * scan.pose.q)};
    (void)owned_.map.update(view, pose, ++tick_);
    now_ns_ += kScan_ns;
    const Labelling& labelling = owned_.segmenter().labelling();
    for (const SegmentEvent& event : labelling.events()) {
      events_.push_back(event);
      if (event.change == SegmentChange::renamed) spoken_.erase(event.id);
    }
    if (now_ns_ - round_ns_ < rt::kNanosecondsPerSecond) return;
    round_ns_ = now_ns_;
    round();
  }

  HallVisit result() {
    for (auto& [id, segment] : spoken_) {
      const WatchedSegment* const watched = watch_.find(id);
      if (watched != nullptr && !watched->speaks) {
        ++visit_.silenced;
      } else {
        visit_.segments.push_back(std::move(segment));
      }
    }
    if (owned_.grid().output().points.pool_full + watch_.counts().refused > 0)
      throw std::runtime_error("descriptors: a hall that does not fit the map");
    return std::move(visit_);
  }

 private:
  static SegmentWatchConfig watch_config() {
    SegmentWatchConfig config;
    config.watched = 1024;
    return config;
  }

  std::uint32_t describe_on() {
    return describer_.run(owned_.grid(), owned_.segmenter().graph(), owned_.segmenter().labelling(),
                          ~std::uint32_t{0});
  }

  void round() {
    const Labelling& labelling = owned_.segmenter().labelling();
    if (describer_.begin(owned_.grid(), labelling) != Status::ok)
      throw std::runtime_error("descriptors: more segments than there is room for");
    double begin = set_cpu_ms();
    (void)describe_on();
    double ms = set_cpu_ms() - begin;
    (void)watch_.begin(now_ns_);
    watch_.note(events_);
    events_.clear();
    std::map<SegmentId, std::uint16_t> slots;
    for (std::uint16_t slot = 0; slot < labelling.slots().size(); ++slot) {
      const std::uint32_t voxels = labelling.slots()[slot].voxels[labelling.shown()];
      if (voxels == 0) continue;
      slots[labelling.id(slot)] = slot;
      watch_.see({labelling.id(slot), voxels, describer_.place(slot), describer_.is_inside(slot)});
    }
    watch_.end();
    std::vector<std::uint16_t> wanted;
    for (const WatchedSegment& segment : watch_.segments()) {
      if (segment.wanted) wanted.push_back(slots.at(segment.id));
    }
    if (describer_.choose(wanted) != Status::ok) throw std::runtime_error("descriptors: not chosen");
    begin = set_cpu_ms();
    (void)describe_on();
    ms += set_cpu_ms() - begin;
    visit_.described_ms.add(ms);
    for (const DescribedSegment& segment : describer_.described()) {
      if (segment.sound && watch_.describe(segment.id, segment.descriptor)) keep(segment);
    }
    visit_.voxels += owned_.grid().output().voxels;
  }

  void keep(const DescribedSegment& segment) {
    SpokenSegment& spoken = spoken_[segment.id];
    spoken.descriptor = segment.descriptor;
    const double voxel_m = owned_.grid().config().voxel_size_m;
    spoken.features = features_of(describer_.moments(segment.slot), describer_.anchor(), voxel_m);
    spoken.voxels.clear();
    const FragmentGraph& graph = owned_.segmenter().graph();
    const unsigned shown = owned_.segmenter().labelling().shown();
    for (std::uint32_t i = 0; i < graph.numbers(); ++i) {
      const FragmentNode& node = graph[static_cast<NodeIndex>(i)];
      if (node.cells == 0 || node.label[shown] != segment.slot) continue;
      const Block& block = owned_.grid().block(node.block);
      const BlockAt at = BlockAt::from_key(block.key);
      for (unsigned cell = 0; cell < 64; ++cell) {
        if ((node.cells >> cell & 1) == 0) continue;
        const Centroid& c = owned_.grid().voxel(block, cell);
        const rt::Vector3 cells{4.0 * at.x + (cell & 3) + c.x / 65536.0,
                                4.0 * at.y + (cell >> 2 & 3) + c.y / 65536.0,
                                4.0 * at.z + (cell >> 4) + c.z / 65536.0};
        spoken.voxels.push_back(rt::rotate(hall_map_.q, voxel_m * cells) + hall_map_.p);
      }
    }
  }

  RigidPose hall_map_, map_hall_;
  tests::OwnedMap<Policy> owned_;
  std::vector<std::byte> memory_;
  rt::Arena arena_;
  SegmentDescriber describer_;
  SegmentWatch watch_;
  std::vector<rt::ScanPoint> points_;
  std::vector<SegmentEvent> events_;
  std::map<SegmentId, SpokenSegment> spoken_;
  rt::Nanoseconds now_ns_{}, round_ns_{};
  rt::Tick tick_{};
  HallVisit visit_;
};

template <class Policy>
HallVisit map_by(const std::vector<HallScan>& scans, const RigidPose& map, bool with_floor) {
  VisitMap<Policy> visit(map);
  for (const HallScan& scan : scans) visit.scan(scan, with_floor);
  return visit.result();
}

}  // namespace

HallVisit map_visit(const std::vector<HallScan>& scans, const RigidPose& map, HallPolicy policy) {
  return policy == HallPolicy::smoothness ? map_by<SmoothnessPolicy>(scans, map, true)
                                          : map_by<EuclideanPolicy>(scans, map, false);
}

}  // namespace sortie::bench
