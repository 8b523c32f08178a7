// SPDX-License-Identifier: BSD-3-Clause
// The scenes of the tracked plant from end to end, through bus, runtime and drive: where the robot ends
// follows from the commands and from the obstacles' sizes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

constexpr double kDegreesInRadian = 57.29577951308232;

struct Ended {
  explicit Ended(const std::string& scene, double seconds, std::vector<std::string> overrides = {}) {
    LiveRunOptions options;
    options.scene = scene;
    options.overrides = std::move(overrides);
    options.seconds = seconds;
    options.virtual_time = true;
    options.lcm_url = "none";
    run = run_live(own_vehicles(), make_simulated_robot, options);
    REQUIRE(run.truth.size() > 100);
    last = run.truth.back();
    for (const TimedPose& pose : run.truth) highest_m = std::max(highest_m, pose.p[2]);
    CHECK(run.results.counters.at("bench_rejected_steps") == 0);
    CHECK(run.results.counters.at("bench_penetration_um") <= 1000);
  }
  double heading_deg() const {
    const double* q = last.q;
    return std::atan2(2 * (q[0] * q[3] + q[1] * q[2]), 1 - 2 * (q[2] * q[2] + q[3] * q[3])) *
           kDegreesInRadian;
  }
  double pitch_deg() const {
    const double* q = last.q;
    return std::asin(std::clamp(2 * (q[0] * q[2] - q[3] * q[1]), -1.0, 1.0)) * kDegreesInRadian;
  }
  LiveRunOutcome run;
  TimedPose last;
  double highest_m{};
};

}  // namespace

TEST_CASE("scenes on the plane end where speed, time and symmetry say", "[model]") {
  const Ended straight("ugv_straight", 17);
  CHECK(straight.last.p[0] == Approx(3.0).margin(6e-3));  // it gains at the end what it lost at the start
  CHECK(std::fabs(straight.last.p[1]) < 1e-3);
  CHECK(std::fabs(straight.heading_deg()) < 0.05);

  const Ended there_and_back("ugv_back_forth", 22);
  CHECK(std::hypot(there_and_back.last.p[0], there_and_back.last.p[1]) < 1e-3);

  const Ended circle("ugv_circle", 31);
  // 0.2 m/s in a circle of less than a metre: never farther away than its diameter, whatever the turning
  // slips.
  double farthest = 0.0;
  double left = 0.0;
  for (const TimedPose& pose : circle.run.truth) {
    farthest = std::max(farthest, std::hypot(pose.p[0], pose.p[1]));
    left = std::max(left, pose.p[1]);
  }
  CHECK(farthest < 2.0);
  CHECK(left > 1.0);

  const Ended rotate("ugv_rotate", 17);
  double turned = 0.0;
  double heading = 0.0;
  for (const TimedPose& pose : rotate.run.truth) {
    const double now = 2 * std::atan2(pose.q[3], pose.q[0]);
    turned += std::remainder(now - heading, 2 * 3.14159265358979323846);
    heading = now;
    CHECK(std::hypot(pose.p[0], pose.p[1]) < 0.3);
  }
  CHECK(turned > 4.0);
  CHECK(turned < 8.0);
}

TEST_CASE("scenes with one obstacle end at its height, level", "[model]") {
  const Ended ramp("ugv_ramp", 19);
  CHECK(ramp.last.p[2] == Approx(2.0 * std::sin(20 / kDegreesInRadian)).margin(1e-3));
  CHECK(std::fabs(ramp.pitch_deg()) < 0.05);

  const Ended stairs("ugv_stairs", 20);
  CHECK(stairs.last.p[2] == Approx(5 * 0.17).margin(1e-3));
  CHECK(std::fabs(stairs.pitch_deg()) < 0.05);
  CHECK(stairs.last.p[0] > 1.0 + 5 * 0.28);
}

TEST_CASE("the rubble scene leads through the rubble and beyond it", "[model]") {
  const Ended rubble("ugv_rubble", 22);
  CHECK(rubble.last.p[0] > 1.0 + 2.4 + 0.4);  // the whole robot has left the field
  CHECK(rubble.highest_m > 0.05);             // and it was over blocks, not beside them
  CHECK(std::fabs(rubble.last.p[2]) < 1e-3);
  CHECK(std::fabs(rubble.pitch_deg()) < 0.05);
}

TEST_CASE("a robot that stands on stairs stays where it is", "[model]") {
  const Ended stand("ugv_stand", 22);
  CHECK(stand.last.p[2] > 0.2);
  CHECK(stand.pitch_deg() < -25);
  const TimedPose* before = nullptr;
  for (const TimedPose& pose : stand.run.truth) {
    if (pose.stamp_ns <= stand.last.stamp_ns - 10'000'000'000) before = &pose;
  }
  REQUIRE(before != nullptr);
  for (int axis = 0; axis < 3; ++axis) CHECK(std::fabs(stand.last.p[axis] - before->p[axis]) < 1e-4);
  double dot = 0.0;
  for (int i = 0; i < 4; ++i) dot += stand.last.q[i] * before->q[i];
  CHECK(2 * std::acos(std::min(std::fabs(dot), 1.0)) < 1e-4);
}

TEST_CASE("the mission leads over every obstacle, through the door and home", "[model]") {
  const Ended mission("ugv_mission", 175);
  CHECK(mission.run.results.counters.at("waypoints_reached") == 9);
  CHECK(mission.run.results.counters.at("drive_stops_stuck") == 0);
  CHECK(mission.highest_m > 4 * 0.17 - 1e-3);
  CHECK(std::hypot(mission.last.p[0], mission.last.p[1]) < 0.8);  // 45 m by dead reckoning
  CHECK(std::fabs(mission.last.p[2]) < 1e-3);
}

TEST_CASE("a robot that is told a place finds its own way there", "[heavy][model]") {
  // Two behind the door, and two of the room where it begins.
  for (const auto& [x_m, y_m] : {std::pair{5.5, -1.0}, {5.2, 1.8}, {-1.0, 3.0}, {2.0, -3.0}}) {
    CAPTURE(x_m, y_m);
    const Ended run("ugv_goal", 90, {"goal.x_m=" + std::to_string(x_m), "goal.y_m=" + std::to_string(y_m)});
    CHECK(std::hypot(run.last.p[0] - x_m, run.last.p[1] - y_m) < 0.25);
    CHECK(run.highest_m < 0.05);  // over nothing
    CHECK(std::fabs(run.pitch_deg()) < 1.0);
    CHECK(run.run.results.counters.at("way_follower_steps") > 10);
    CHECK(run.run.results.counters.at("drive_stops_tilted") == 0);
  }
}

TEST_CASE("a robot that is told a place outside of its hall stays in it and stands in the end",
          "[heavy][model]") {
  const Ended run("ugv_goal", 90, {"goal.x_m=3.5", "goal.y_m=9.0"});
  CHECK(std::fabs(run.last.p[0]) < 11.0);
  CHECK(std::fabs(run.last.p[1]) < 4.0);
  CHECK(run.highest_m < 0.05);
  CHECK(run.run.results.counters.at("drive_stops_tilted") == 0);
}
