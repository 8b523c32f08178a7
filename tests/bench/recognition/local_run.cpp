// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/local_run.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mapping/recognition/target_keeper.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;

constexpr rt::Nanoseconds kScan_ns = 500'000'000;
const tests::MapSizes kSizes{65'534, 262'136, 65'534, 32'768, 2048, 4096};

RollingGridConfig grid_config(double radius_m) {
  RollingGridConfig config;
  config.max_range_m = 25.0;
  config.radius_m = radius_m;
  return config;
}

SegmentWatchConfig watch_config() {
  SegmentWatchConfig config;
  config.watched = 1024;
  return config;
}

}  // namespace

PoseError error_of(const RigidPose& told, const RigidPose& truth) {
  const double turn = rt::norm(rt::log_rotation(told.q * rt::conjugate(truth.q)));
  return {rt::norm(told.p - truth.p), turn * 180.0 / M_PI};
}

RigidPose pose_of(const LevelPlace& place) {
  return {{place.x_m, place.y_m, place.z_m},
          rt::from_yaw_pitch_roll(std::atan2(place.sine, place.cosine), 0, 0)};
}

void TrialMemory::check() const {
  if (arena.refused() != 0) throw std::runtime_error("recognition: no room for a trial");
}

LocalRun::LocalRun(double radius_m)
    : memory_(2),
      map_(grid_config(radius_m), SegmenterConfig{}, kSizes),
      segments_(watch_config(), kSizes.slots, 256, memory_.arena) {
  memory_.check();
}

bool LocalRun::scan(const std::vector<rt::ScanPoint>& points, const RigidPose& T_odom_sensor) {
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
    throw std::runtime_error("recognition: a world that does not fit the map");
  return true;
}

std::vector<SpeakingSegment> LocalRun::speaking(std::uint32_t most) const {
  std::vector<SpeakingSegment> list;
  for (const WatchedSegment& one : segments_.segments()) {
    if (!one.speaks) continue;
    const rt::Vector3 at = grid().to_world({0.01 * one.place.x, 0.01 * one.place.y, 0.01 * one.place.z});
    list.push_back({one.id, one.version, to_cm(at), one.descriptor});
  }
  const PlaceCm middle = to_cm(middle_of(grid()));
  std::sort(list.begin(), list.end(), [&](const SpeakingSegment& a, const SpeakingSegment& b) {
    const std::int64_t x = square_apart(a.place, middle), y = square_apart(b.place, middle);
    return x != y ? x < y : a.id < b.id;
  });
  if (list.size() > most) list.resize(most);
  return list;
}

std::vector<rt::Vector3> LocalRun::voxels() const {
  const double voxel_m = grid().config().voxel_size_m;
  std::vector<rt::Vector3> places;
  for (const Block& block : grid().blocks()) {
    if (!block.in_use()) continue;
    const BlockAt at = BlockAt::from_key(block.key);
    for (std::uint64_t rest = block.active; rest != 0; rest = without_lowest(rest)) {
      const unsigned cell = lowest(rest);
      const Centroid& c = grid().voxel(block, cell);
      const rt::Vector3 cells{4.0 * at.x + (cell & 3) + c.x / 65536.0,
                              4.0 * at.y + (cell >> 2 & 3) + c.y / 65536.0,
                              4.0 * at.z + (cell >> 4) + c.z / 65536.0};
      places.push_back(grid().to_world(voxel_m * cells));
    }
  }
  return places;
}

}  // namespace sortie::bench
