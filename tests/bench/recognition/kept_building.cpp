// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/kept_building.hpp"

#include <stdexcept>

#include "mapping/registration/pose_algebra.hpp"

namespace sortie::bench {
using namespace mapping;
using testing::Draws;
namespace {
constexpr double kRadius_m = 20.0;
constexpr double kApart_m = 100.0;
constexpr double kLook_m = 2.0, kMostWay_m = 15.0;
constexpr std::uint32_t kMostKeyFrames = 4096;
}  // namespace

KeptBuilding::KeptBuilding(int halls, int worlds_of_a_kind, std::uint64_t seed)
    : memory_(8), keeping_(kRadius_m) {
  for (const std::uint32_t targets : kTargets) {
    TargetStoreConfig config;
    config.targets = targets;
    config.key_frames = kMostKeyFrames;
    keepers_.emplace_back(TargetKeeperConfig{}, config, memory_.arena);
  }
  memory_.check();
  for (int i = 0; i < halls; ++i) {
    Draws draws(seed + static_cast<std::uint64_t>(i));
    const SecondWay way = i % 3 == 1 ? SecondWay::against : SecondWay::along;
    take(revisited_hall(way, i % 3 == 2 ? 0.3 : 0.0, draws), true, draws);
  }
  for (const Deception kind : kDeceptions) {
    for (int i = 0; i < worlds_of_a_kind; ++i) {
      Draws draws(seed + static_cast<std::uint64_t>(i));
      take(deceptive_world(kind, draws), false, draws);
    }
  }
  for (TargetKeeper& keeper : keepers_) {
    if (keeper.key_frames() == kMostKeyFrames) throw std::runtime_error("sweep: too many key frames");
    std::uint64_t all = ~std::uint64_t{0} >> 1;
    keeper.run(all);
  }
}

const TargetStore& KeptBuilding::store(std::uint32_t targets) const {
  for (std::size_t i = 0; i < std::size(kTargets); ++i) {
    if (kTargets[i] == targets) return keepers_[i].store();
  }
  throw std::runtime_error("sweep: no store of that size");
}

RigidPose KeptBuilding::T_kept_world() const { return {{kApart_m * static_cast<double>(worlds_), 0, 0}, {}}; }

void KeptBuilding::take(const RecognitionWorld& world, bool is_hall, Draws& draws) {
  const auto lidar = [&] { return is_hall ? hall_lidar(draws) : sparse_lidar(draws); };
  const HallLidar first = lidar(), second = lidar();
  keep(world, first, draws);
  look(world, is_hall, second, draws);
  ++worlds_;
  halls_ += is_hall ? 1 : 0;
}

void KeptBuilding::keep(const RecognitionWorld& world, const HallLidar& lidar, Draws& draws) {
  for (const HallAt& place : world.kept) {
    const RigidPose T_kept_hall = after(T_kept_world(), place.T_world_hall);
    for (const HallScan& scan : visit_scans(place.hall, 0, lidar, draws)) {
      if (!keeping_.scan(scan.points, after(T_kept_hall, scan.pose))) continue;
      for (TargetKeeper& keeper : keepers_)
        keeper.keep(keeping_.segments(), keeping_.grid(), {}, keeping_.now_ns());
    }
  }
}

void KeptBuilding::look(const RecognitionWorld& world, bool is_hall, const HallLidar& lidar, Draws& draws) {
  LocalRun run(kRadius_m);
  const RigidPose T_kept_hall = after(T_kept_world(), world.now.T_world_hall);
  const RigidPose T_odom_world{{draws.uniform(-20, 20), draws.uniform(-20, 20), draws.uniform(-1, 1)},
                               rt::from_yaw_pitch_roll(draws.uniform(-M_PI, M_PI), 0, 0)};
  const RigidPose T_odom_hall = after(T_odom_world, world.now.T_world_hall);
  double way_m = 0.0, next_m = kLook_m;
  const std::vector<HallScan> scans = visit_scans(world.now.hall, 1, lidar, draws);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (i > 0) way_m += rt::norm(scans[i].pose.p - scans[i - 1].pose.p);
    if (way_m > kMostWay_m) break;
    const RigidPose odom = after(T_odom_hall, scans[i].pose);
    if (!run.scan(scans[i].points, odom) || way_m < next_m) continue;
    next_m += kLook_m;
    looks_.push_back({worlds_, is_hall, world.is_kept, odom, after(T_kept_hall, scans[i].pose),
                      run.speaking(RecogniserConfig::kMostSegments)});
  }
}

}  // namespace sortie::bench
