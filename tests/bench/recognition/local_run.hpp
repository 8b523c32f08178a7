// SPDX-License-Identifier: BSD-3-Clause
// The local map of a trial, as it runs on board.
#pragma once

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <vector>

#include "mapping/recognition/local_segments.hpp"
#include "mapping/recognition/recogniser.hpp"
#include "mapping/recognition/target_keeper.hpp"
#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {

/// Memory of a trial.
struct TrialMemory {
  std::unique_ptr<std::byte[]> bytes;
  rt::Arena arena;
  explicit TrialMemory(std::size_t mb) : bytes(new std::byte[mb << 20]), arena({bytes.get(), mb << 20}) {}
  void check() const {
    if (arena.refused() != 0) throw std::runtime_error("recognition: no room for a trial");
  }
};

/// A local map and its segments that may speak.
class LocalRun {
 public:
  explicit LocalRun(double radius_m)
      : memory_(2),
        map_(grid_config(radius_m), mapping::SegmenterConfig{}, kSizes),
        segments_(watch_config(), kSizes.slots, 256, memory_.arena) {
    memory_.check();
  }

  /// True: a round was due, and the segments are new.
  bool scan(const std::vector<rt::ScanPoint>& points, const mapping::RigidPose& T_odom_sensor) {
    rt::PointScan view;
    view.header.points = static_cast<std::uint32_t>(points.size());
    view.points = points.data();
    (void)map_.map.update(view, T_odom_sensor, ++tick_);
    now_ns_ += kScan_ns;
    segments_.note(map_.segmenter().labelling());
    if (now_ns_ - round_ns_ < rt::kNanosecondsPerSecond) return false;
    round_ns_ = now_ns_;
    std::uint32_t units = 0;
    const Status status =
        segments_.round(map_.grid(), map_.segmenter().graph(), map_.segmenter().labelling(), now_ns_, units);
    if (status != Status::ok || map_.grid().output().points.pool_full + segments_.events_lost() > 0)
      throw std::runtime_error("recognition: a hall that does not fit the map");
    return true;
  }
  const mapping::RollingGrid& grid() const { return map_.grid(); }
  std::span<const mapping::WatchedSegment> segments() const { return segments_.segments(); }
  rt::Nanoseconds now_ns() const { return now_ns_; }

  /// Those that speak, the nearest `most` of them.
  std::vector<mapping::SpeakingSegment> speaking(std::uint32_t most) const {
    std::vector<mapping::SpeakingSegment> list;
    for (const mapping::WatchedSegment& one : segments_.segments()) {
      if (!one.speaks) continue;
      const rt::Vector3 at = grid().to_world({0.01 * one.place.x, 0.01 * one.place.y, 0.01 * one.place.z});
      list.push_back({one.id, one.version, mapping::to_cm(at), one.descriptor});
    }
    const mapping::PlaceCm middle = mapping::to_cm(mapping::middle_of(grid()));
    std::sort(list.begin(), list.end(), [&](const auto& a, const auto& b) {
      const std::int64_t x = mapping::square_apart(a.place, middle),
                         y = mapping::square_apart(b.place, middle);
      return x != y ? x < y : a.id < b.id;
    });
    if (list.size() > most) list.resize(most);
    return list;
  }

 private:
  static constexpr rt::Nanoseconds kScan_ns = 500'000'000;
  static constexpr tests::MapSizes kSizes{65'534, 262'136, 65'534, 16'384, 2048, 4096};

  static mapping::RollingGridConfig grid_config(double radius_m) {
    mapping::RollingGridConfig config;
    config.max_range_m = 25.0;
    config.radius_m = radius_m;
    return config;
  }
  static mapping::SegmentWatchConfig watch_config() {
    mapping::SegmentWatchConfig config;
    config.watched = 1024;
    return config;
  }
  TrialMemory memory_;
  tests::SmoothMap map_;
  mapping::LocalSegments segments_;
  rt::Nanoseconds now_ns_{}, round_ns_{};
  rt::Tick tick_{};
};

}  // namespace sortie::bench
