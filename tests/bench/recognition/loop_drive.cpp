// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/loop_drive.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/recognition/target_keeper.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "tests/bench/recognition/scan_check.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;
using testing::Draws;

constexpr double kSensor_m = 1.0;
constexpr double kSway = 1.5 * M_PI / 180.0;
constexpr double kSeen_m = 25.0;
constexpr double kSurfaces_m = 12.0;  ///< scans from so near a place make its surfaces
constexpr double kHeight_m = 0.005;   ///< the odometry's height drifts, a root of a metre
constexpr std::uint64_t kAll = ~std::uint64_t{0} >> 1;

/// Where the odometry lies to the world as it drifts.
class DriftingFrame {
 public:
  DriftingFrame(const LoopDriveConfig& config, Draws& draws)
      : config_(&config), bias_(draws.uniform(-1, 1) * config.drift_share) {}
  /// The sensor has moved by `moved` in the world, and is at `now`.
  void move(const rt::Vector3& moved, const rt::Vector3& now, Draws& draws) {
    const double way_m = rt::norm(moved), root = std::sqrt(way_m);
    const double turn = config_->drift_deg * root * M_PI / 180.0 * draws.normal();
    const double share = bias_ + config_->drift_share * draws.normal();
    const rt::Vector3 here = T_odom_world_.p + rt::rotate(T_odom_world_.q, now);
    const rt::Vector3 slip = share * rt::rotate(T_odom_world_.q, moved);
    const rt::Quaternion q = rt::from_yaw_pitch_roll(turn, 0, 0);
    T_odom_world_.q = rt::normalised(q * T_odom_world_.q);
    T_odom_world_.p = here - rt::rotate(T_odom_world_.q, now) + slip;
    T_odom_world_.p.z += kHeight_m * root * draws.normal();
  }
  const RigidPose& T_odom_world() const { return T_odom_world_; }

 private:
  const LoopDriveConfig* config_;
  double bias_;
  RigidPose T_odom_world_;
};

/// A place that was passed, the odometry's frame then, and of one scan in two what is matched with.
struct Passed {
  RigidPose T_world_sensor;
  RigidPose T_odom_world;
  std::vector<SamplePoint> sample;
};

PoseError least_error(const RigidPose& told, const RigidPose& T_world_sensor,
                      std::span<const Passed> passed) {
  PoseError least{std::numeric_limits<double>::infinity(), 180.0};
  for (const Passed& one : passed) {
    if (rt::norm(one.T_world_sensor.p - T_world_sensor.p) > kSeen_m) continue;
    const PoseError error = error_of(told, after(one.T_odom_world, T_world_sensor));
    if (error.move_m < least.move_m) least = error;
  }
  return least;
}

/// Surfaces about some places in the odometry, as they were left there.
std::unique_ptr<SurfaceMap> surfaces_about(std::span<const RigidPose> places, std::span<const Passed> passed,
                                           const RelocateConfig& config) {
  auto map = std::make_unique<SurfaceMap>(config);
  for (const Passed& one : passed) {
    const RigidPose T_odom_sensor = after(one.T_odom_world, one.T_world_sensor);
    const auto is_near = [&](const RigidPose& place) {
      return rt::norm(place.p - T_odom_sensor.p) <= kSurfaces_m;
    };
    if (one.sample.empty() || std::none_of(places.begin(), places.end(), is_near)) continue;
    map->registration.take_sample(one.sample);
    map->registration.insert(T_odom_sensor);
  }
  return map;
}

}  // namespace

LoopDrive drive_loops(const StreetCourse& course, const StreetTown& town, const HallLidar& lidar,
                      const LoopDriveConfig& config, Draws& draws) {
  TrialMemory memory(16);
  TargetStoreConfig store;
  store.targets = config.targets;
  TargetKeeper keeper({}, store, memory.arena);
  Recogniser recogniser(config.recogniser, memory.arena);
  memory.check();
  LocalRun run(config.radius_m);
  SurfaceMap sampler(config.judge);  // its map stays empty
  DriftingFrame frame(config, draws);
  const std::vector<double> nearest = distance_to_left(course, config.lately_m);
  const auto lately = static_cast<std::size_t>(config.lately_m / course.step_m);
  std::vector<Passed> passed;
  LoopDrive drive;
  std::uint64_t units = kAll;
  for (std::size_t i = 0; i < course.poses.size(); ++i) {
    const CoursePose& pose = course.poses[i];
    const RigidPose truth{
        {pose.x, pose.y, kSensor_m},
        rt::from_yaw_pitch_roll(pose.heading, draws.uniform(-kSway, kSway), draws.uniform(-kSway, kSway))};
    if (i > 0) frame.move(truth.p - passed.back().T_world_sensor.p, truth.p, draws);
    const RigidPose odom = after(frame.T_odom_world(), truth);
    const std::vector<rt::ScanPoint> points = scan_points(town, truth, lidar, draws);
    passed.push_back({truth, frame.T_odom_world(), {}});
    if (!run.scan(points, odom)) continue;
    sampler.registration.take(points);
    passed.back().sample.assign(sampler.registration.sample().begin(), sampler.registration.sample().end());
    const std::vector<SpeakingSegment> speaking = run.speaking(recogniser.config().segments);
    LoopLook look;
    look.way_m = course.step_m * static_cast<double>(i);
    look.nearest_m = nearest[i];
    look.speaking = static_cast<std::uint32_t>(speaking.size());
    // A metre a second: as many metres lately as seconds.
    CandidateQuery where;
    where.leaves_out = true;
    where.since_ms = static_cast<std::uint32_t>(
        std::max(0.0, static_cast<double>(run.now_ns()) * 1e-6 - 1e3 * config.lately_m));
    recogniser.begin(speaking, where);
    (void)recogniser.run(keeper.store(), units = kAll);
    look.verdict = recogniser.verdict();
    if (!recogniser.found().empty()) look.agree = recogniser.found()[0].count;
    if (look.verdict == SetVerdict::found) {
      const std::span<const Passed> before(passed.data(), i > lately ? i - lately : 0);
      const RigidPose told = after(pose_of(recogniser.found()[0].fit.place), odom);
      look.found = least_error(told, truth, before);
      const rt::Quaternion tilt = rt::exp_rotation({0.006 * draws.normal(), 0.006 * draws.normal(), 0});
      const CheckedScan scan{passed.back().sample, odom, rt::normalised(tilt * odom.q)};
      std::unique_ptr<SurfaceMap> map;
      const auto surfaces = [&]() -> PlaceJudge& {
        std::vector<RigidPose> places;
        for (const SetHypothesis& place : recogniser.found())
          places.push_back(after(pose_of(place.fit.place), odom));
        map = surfaces_about(places, before, config.judge);
        return map->judge;
      };
      JudgedPlace judged;
      if (place_by_scan(scan, recogniser, keeper.store(), surfaces, judged))
        look.placed = least_error(judged.T_map_sensor, truth, before);
    }
    drive.looks.push_back(look);
    // What is seen again becomes the target that it was: after the search, which would leave it out.
    keeper.keep(run.segments(), run.grid(), {}, run.now_ns());
    keeper.run(units = kAll);
  }
  drive.scans = passed.size();
  drive.targets = keeper.store().kept();
  drive.evicted = keeper.store().counts().evicted;
  if (!passed.empty()) {
    const rt::Vector3& end = passed.back().T_world_sensor.p;
    const RigidPose& T = frame.T_odom_world();
    drive.drifted_m = rt::norm(T.p + rt::rotate(T.q, end) - end);
    drive.drifted_deg = rt::norm(rt::log_rotation(T.q)) * 180.0 / M_PI;
  }
  return drive;
}

}  // namespace sortie::bench
