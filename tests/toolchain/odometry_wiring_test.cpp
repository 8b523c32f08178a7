// SPDX-License-Identifier: BSD-3-Clause
// The odometry in the vehicle: what it is given where a scene has obstacles, what it says about itself, and
// that a scene without them has nothing of it. The twin is the bare chain over the recorded samples.
#include <catch2/catch.hpp>
#include <map>

#include "firmware_like/parts/odometry_state.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "toolchain/bench/odometry_bench.hpp"

namespace {

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

/// Up the first steps of the stairs, recorded once a program.
struct RecordedClimb {
  RecordedClimb() {
    LiveRunOptions options;
    options.scene = "ugv_stairs";
    options.overrides = {"hil.lidar_rows=4", "hil.lidar_columns=64", "limits.voxels=32768"};
    options.seconds = 9;
    options.virtual_time = true;
    options.record = log;
    options.record_fields = true;
    options.lcm_url = "none";
    run = run_live(own_vehicles(), make_simulated_robot, options);
  }
  TempFolder folder;
  std::string log = folder.file("climb.lcm");
  LiveRunOutcome run;
};
const RecordedClimb& climb() {
  static const RecordedClimb recorded;
  return recorded;
}

/// What the task odometry_state put out, by the stamp of the sample that it tells about: the last word.
std::map<rt::Nanoseconds, OdometryState> states_of(const std::string& log) {
  std::map<rt::Nanoseconds, OdometryState> states;
  ReplayOptions options;
  options.on_job = [&](const rt::JobRecord& record, Runtime& runtime) {
    std::uint32_t offset = 0;
    for (const rt::TaskBase* task : runtime.executive().group(record.group).tasks) {
      OdometryState state;
      if (std::string(task->name()) == "odometry_state" &&
          offset + task->output_bytes() <= record.field_bytes) {
        rt::decode_canonical(record.fields + offset, state);
        states[state.stamp_ns] = state;
      }
      offset += task->output_bytes();
    }
  };
  static_cast<void>(replay_log(log, options));
  return states;
}

std::unique_ptr<Runtime> built(std::vector<std::string> overrides) {
  overrides.insert(overrides.end(), {"limits.voxels=1024"});
  return std::make_unique<Runtime>(load_scene("ugv_stairs", overrides), own_vehicles(), RuntimeStart{});
}

bool has_port(Runtime& runtime, const std::string& channel) {
  for (const auto& port : runtime.parts().ports()) {
    if (port->channel() == channel) return true;
  }
  return false;
}

bool has_task(Runtime& runtime, const std::string& name) {
  for (std::uint32_t i = 0; i < runtime.executive().task_count(); ++i) {
    if (runtime.executive().task(i).name() == name) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("the vehicle's odometry is the bare chain over the same samples, to the bit") {
  const LogFile log(climb().log);
  const OdometrySet set = read_odometry_set(log, "");
  REQUIRE(set.odometry.obstacles);
  REQUIRE(set.flippers.size() > 100);
  for (const char* variant : {"all, double", "no obstacle modes"}) {
    INFO(variant);
    ReplayOptions options;
    if (variant != std::string("all, double")) {
      // With the turning centre that a described body gives.
      options.overrides = {"odometry.obstacles=\"off\"",
                           "odometry.icr_x_m=" + std::to_string(set.odometry.icr_x_m)};
    }
    const Trajectory bare = run_odometry_variant(set, variant);
    const Trajectory vehicle = replay_log(climb().log, options).estimate;
    std::map<std::int64_t, const TimedPose*> at;
    for (const TimedPose& pose : vehicle) at[pose.stamp_ns] = &pose;
    std::size_t compared = 0;
    double gap = 0.0;
    for (const TimedPose& pose : bare) {
      const auto found = at.find(pose.stamp_ns);
      if (found == at.end()) continue;
      ++compared;
      for (int i = 0; i < 3; ++i) gap = std::max(gap, std::fabs(pose.p[i] - found->second->p[i]));
    }
    CHECK(compared > 800);
    CHECK(gap < 1e-6);  // the override above has six digits
    if (variant == std::string("all, double")) CHECK(gap == 0.0);
  }
}

TEST_CASE("modes make the height of stairs better by half, and switched off they are the plain method") {
  const auto errors = errors_of(climb().run);
  ReplayOptions off;
  off.overrides = {"odometry.obstacles=\"off\""};
  const ReplayOutcome plain = replay_log(climb().log, off);
  CHECK(errors.at("vertical_rmse_m") < 0.5 * errors_of(plain).at("vertical_rmse_m"));
  CHECK(errors.count("drift_vertical_percent") == 1);
  CHECK(errors.count("drift_horizontal_percent") == 1);
}

TEST_CASE("a run with obstacles replays to its digest, whole and from keyframes") {
  const Indexed indexed = replay_and_keep(climb().log, own_vehicles(), {}, 2000, keyframe_path(climb().log));
  CHECK(complaint_of(indexed.outcome) == "");
  ReplayOptions part;
  part.from = "6.5";
  const ReplayOutcome late = replay_log(climb().log, part);
  CHECK(late.diverged_jobs == 0);
  CHECK(late.compared_jobs > 1000);
  CHECK_FALSE(late.divergence.has_value());
}

TEST_CASE("the state of the odometry tells what the estimators know") {
  const std::map<rt::Nanoseconds, OdometryState> states = states_of(climb().log);
  REQUIRE(states.size() > 800);
  const OdometryState& last = states.rbegin()->second;
  const auto& counters = climb().run.results.counters;
  CHECK(last.track_used == counters.at("track_used"));
  CHECK(last.imu_used == counters.at("imu_used"));
  CHECK(last.imu_saturated == counters.at("imu_saturated"));
  CHECK(last.slips == counters.at("track_slips"));
  CHECK(last.health == 0);
  // Modes and heights against the bare odometry over the same samples.
  const LogFile log(climb().log);
  const OdometrySet set = read_odometry_set(log, "");
  estimators::Attitude attitude(set.attitude);
  estimators::TrackOdometry odometry(set.odometry);
  std::map<std::uint32_t, int> modes;
  std::size_t compared = 0;
  for (const OdometryEvent& event : set.events) {
    if (event.kind == OdometryEvent::Kind::flippers) {
      const double* angle = set.flippers[event.index].angle_rad;
      odometry.set_flippers({0.5 * (angle[0] + angle[1]), 0.5 * (angle[2] + angle[3])});
    } else if (event.kind == OdometryEvent::Kind::imu) {
      if (attitude.update(set.imu[event.index]) != Status::ok) continue;
      static_cast<void>(odometry.observe(attitude.estimate()));
      odometry.feel(set.imu[event.index]);
    } else {
      if (odometry.update(set.track[event.index]) != Status::ok) continue;
      const auto found = states.find(odometry.estimate().stamp_ns);
      attitude.set_moving(odometry.belts_run());
      static_cast<void>(attitude.set_track_velocity(rt::to_vector(odometry.estimate().v_body_m_s),
                                                    odometry.estimate().stamp_ns));
      if (found == states.end()) continue;
      ++compared;
      ++modes[found->second.mode];
      const estimators::ObstacleState obstacle = odometry.obstacle();
      REQUIRE(found->second.mode == obstacle.mode);
      REQUIRE(found->second.confidence == obstacle.confidence);
      REQUIRE(found->second.step_height_m == obstacle.step_height_m);
      REQUIRE(found->second.steering_efficiency == odometry.steering().value());
      REQUIRE(found->second.sigma_vertical_m == std::sqrt(odometry.estimate().covariance[14]));
    }
  }
  CHECK(compared > 800);
  CHECK(modes.size() >= 3);  // it stood, drove and climbed
}

TEST_CASE("health says what is wrong") {
  estimators::TrackOdometryConfig config;
  config.track_width_m = 0.4;
  config.obstacles = true;
  estimators::TrackOdometry odometry(config);
  estimators::Attitude attitude({});
  CHECK((odometry_state(odometry, attitude.estimate(), attitude.counters()).health & kOdometryNotStarted) !=
        0);
  CHECK((odometry_state(odometry, attitude.estimate(), attitude.counters()).health & kOdometryNotLevelled) !=
        0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(odometry.update({1'000'000, nan, 0.0, 0}) == Status::not_finite);
  CHECK(odometry.update({2'000'000, 0.0, 0.0, 0}) == Status::ok);
  CHECK(odometry.update({2'000'000, 0.0, 0.0, 0}) == Status::time_repeated);
  CHECK(odometry.update({30'000'000, 50.0, 50.0, 0}) != Status::ok);
  CHECK(attitude.update({1'000'000, {nan, 0, 0}, {0, 0, 9.81}, rt::kImuGyr | rt::kImuAcc}) != Status::ok);
  const OdometryState state = odometry_state(odometry, attitude.estimate(), attitude.counters());
  CHECK(state.track_not_finite == 1);
  CHECK(state.track_time == 1);
  CHECK(state.track_jumps == 1);
  CHECK(state.imu_not_finite == 1);
  CHECK((state.health & kOdometryNotStarted) == 0);
}

TEST_CASE("a scene that leaves obstacles out has no stream, task or memory for them") {
  const auto full = built({});
  CHECK(has_port(*full, "FLIPPER"));
  CHECK(has_task(*full, "odometry_state"));
  const std::string no_flippers = "tasks.flippers.enabled=false";
  const auto without_task = built({no_flippers, "flippers={}", "mission.commands=[]"});
  CHECK(has_port(*without_task, "FLIPPER"));  // nobody moves them, the odometry still asks where they are
  const auto flat = built({no_flippers, "flippers={}", "mission.commands=[]", "odometry.obstacles=\"off\""});
  CHECK_FALSE(has_port(*flat, "FLIPPER"));
  CHECK_FALSE(has_task(*flat, "odometry_state"));
  CHECK(flat->memory_bytes() < without_task->memory_bytes());
  const auto bare = built({no_flippers, "flippers={}", "mission.commands=[]", "body.flippers=false"});
  CHECK_FALSE(has_port(*bare, "FLIPPER"));
  // What is left out is not configured either.
  CHECK(mentions(message_of<ProfileError>([] {
                   static_cast<void>(built({"odometry.obstacles=\"off\"", "body.radius_m=0.1"}));
                 }),
                 "body"));
}

TEST_CASE("The attitude in single precision leads where the one in double does, and replays to its digest") {
  LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = {"hil.lidar_rows=4", "hil.lidar_columns=64", "limits.voxels=32768",
                       "attitude.precision=float"};
  options.seconds = 8;
  options.virtual_time = true;
  options.lcm_url = "none";
  TempFolder folder;
  options.record = folder.file("float.lcm");
  const LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot, options);
  const ReplayOutcome again = replay_log(options.record);
  CHECK(again.results.digest == run.results.digest);
  ReplayOptions in_double;
  in_double.overrides = {"attitude.precision=double"};
  const ReplayOutcome twin = replay_log(options.record, in_double);
  CHECK(twin.results.digest != again.results.digest);  // the key does something
  REQUIRE(twin.estimate.size() == again.estimate.size());
  REQUIRE(!twin.estimate.empty());
  double apart_m = 0;
  double apart_rad = 0;
  for (std::size_t i = 0; i < twin.estimate.size(); ++i) {
    const auto& a = twin.estimate[i];
    const auto& b = again.estimate[i];
    apart_m = std::max(apart_m, std::hypot(a.p[0] - b.p[0], a.p[1] - b.p[1], a.p[2] - b.p[2]));
    const auto q = conjugate(rt::to_quaternion(a.q)) * rt::to_quaternion(b.q);
    apart_rad = std::max(apart_rad, 2 * std::hypot(q.x, q.y, q.z));
  }
  CHECK(apart_m < 0.001);
  CHECK(apart_rad < 1.745e-4);  // 0.01 degrees
}
