// SPDX-License-Identifier: BSD-3-Clause
// Every reason to stop and the way back from it, limits and time.
#include "planner/ugv_drive.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <vector>

#include "rt/fields.hpp"
#include "tests/planner/drive_twin.hpp"

using namespace sortie;
using namespace sortie::planner;
using namespace sortie::planner::test;

namespace {

/// Runs until the robot stands; gives the seconds that took.
double seconds_to_stand(Bench& bench, const UgvDriveInputs& inputs) {
  int steps = 0;
  for (; !bench.stands() && steps < 2000; ++steps) bench.run(rt::to_seconds(kStep_ns), inputs);
  return steps * rt::to_seconds(kStep_ns);
}

/// From `v` to rest with the stop's deceleration and jerk.
double shortest_stop(double v, const RampLimits& stop) {
  return v / stop.acceleration + stop.acceleration / stop.jerk;
}

}  // namespace

TEST_CASE(
    "Every reason stops with the deceleration that is set, is named and counted, and ends by its rule") {
  struct Case {
    DriveStop reason;
    UgvDriveInputs inputs;
    void (*provoke)(Bench&);
    void (*undo)(Bench&);
    std::uint32_t DriveStopCounters::*counter;
    const char* name;
  };
  const auto nothing = [](Bench&) {};
  const Case cases[] = {
      {kStopImuStale, {true, false}, nothing, nothing, &DriveStopCounters::imu_stale, "imu_stale"},
      {kStopOdometryStale,
       {false, true},
       nothing,
       nothing,
       &DriveStopCounters::odometry_stale,
       "odometry_stale"},
      {kStopTilted,
       {},
       [](Bench& b) { b.robot.roll = 0.75; },
       [](Bench& b) { b.robot.roll = 0.0; },
       &DriveStopCounters::tilted,
       "tilted"},
      {kStopTilted,
       {},
       [](Bench& b) { b.robot.pitch = -0.85; },
       [](Bench& b) { b.robot.pitch = 0.1; },
       &DriveStopCounters::tilted,
       "tilted"},
      {kStopHalt,
       {},
       [](Bench& b) {
         rt::DriveRequest halt = request_of(0, 0, rt::DriveMode::halt);
         halt.stamp_ns = b.now_ns;
         halt.counter = b.drive.output().request_counter + 1;
         REQUIRE(b.drive.request(halt, b.now_ns) == Status::ok);
       },
       [](Bench& b) {
         rt::DriveRequest release = request_of(0, 0, rt::DriveMode::release);
         release.stamp_ns = b.now_ns;
         release.counter = b.drive.output().request_counter + 1;
         REQUIRE(b.drive.request(release, b.now_ns) == Status::ok);
       },
       &DriveStopCounters::halt,
       "halt"},
  };
  for (const Case& c : cases) {
    INFO(c.name);
    Bench bench = on_the_road();
    const DriveStopCounters before = bench.drive.output().stops;
    c.provoke(bench);
    const double took = seconds_to_stand(bench, c.inputs);
    CHECK(took == Approx(shortest_stop(bench.config.max_speed_m_s, bench.config.stop)).margin(0.02));
    bench.run(1.0, c.inputs);
    CHECK(bench.stands());
    CHECK(bench.stop() == c.reason);
    CHECK(bench.has(kDriveStopping));
    CHECK_FALSE(bench.has(kDriveEnabled));
    CHECK(bench.drive.output().stops.*c.counter == before.*c.counter + 1);
    std::string names;
    for_each_drive_stop(c.reason, [&](const char* name) { names += name; });
    CHECK(names == c.name);
    c.undo(bench);
    bench.run(0.09);  // the reason is gone, the wait is not over
    CHECK(bench.stop() == 0);
    CHECK(bench.has(kDriveStopping));
    CHECK(bench.stands());
    bench.run(3.0);
    CHECK(bench.drive.output().speed_m_s == Approx(bench.config.max_speed_m_s));
    CHECK(bench.drive.output().stops.*c.counter == before.*c.counter + 1);
  }
  for_each_drive_stop(~1023u, [](const char* name) { FAIL_CHECK(name); });
}

TEST_CASE("A lost pose stops in every way that a pose can be lost") {
  for (int kind = 0; kind < 4; ++kind) {
    INFO("kind " << kind);
    Bench bench = on_the_road();
    rt::PoseEstimate bad = bench.robot.pose(bench.now_ns);  // kind 3: goes on saying this
    const rt::Nanoseconds lost_ns = bench.now_ns;
    if (kind == 0) bad.p_world_body_m[0] = kNan;
    if (kind == 1) bad.q_world_body[2] = std::numeric_limits<double>::infinity();
    if (kind == 2) bad.flags = 0;
    for (int i = 0; i < 400; ++i) {
      bench.now_ns += kStep_ns;
      REQUIRE(bench.step_with(bad) == Status::ok);
      const bool lost = kind < 3 || bench.now_ns - lost_ns > bench.config.guard.max_pose_age_ns;
      REQUIRE((bench.stop() == kStopPoseLost) == lost);
    }
    REQUIRE(bench.good);
    CHECK(bench.stands());
    CHECK(bench.drive.output().stops.pose_lost == 1);
    bench.run(3.0);
    CHECK(bench.drive.output().speed_m_s == Approx(bench.config.max_speed_m_s));
  }
}

TEST_CASE("A reason that comes and goes in a moment is carried through to rest all the same") {
  Bench bench = on_the_road();
  bench.run(0.005, {true, false});
  bench.run(0.2);
  CHECK(bench.stop() == 0);
  CHECK(bench.has(kDriveStopping));
  CHECK(bench.drive.output().speed_m_s < bench.config.max_speed_m_s - 0.1);
  double least = 1;
  for (int i = 0; i < 200; ++i) {
    bench.run(0.005);
    least = std::min(least, bench.drive.output().speed_m_s);
    REQUIRE(bench.drive.output().speed_m_s >= 0.0);  // never backwards
  }
  CHECK(least == 0.0);
  bench.run(3.0);
  CHECK(bench.drive.output().speed_m_s == Approx(bench.config.max_speed_m_s));
}

TEST_CASE("A tilt ends below the limit by the hysteresis, and can be driven off slowly on request") {
  Bench bench = on_the_road();
  bench.robot.roll = 0.71;
  bench.run(2.0);
  REQUIRE(bench.stop() == kStopTilted);
  bench.robot.roll = 0.61;  // below the limit of 0.7, not by 0.1
  bench.run(1.0);
  CHECK(bench.stop() == kStopTilted);
  bench.ask(1.0, request_of(-0.5, 0.4));
  CHECK(bench.stop() == kStopTilted);
  rt::DriveRequest off = request_of(-0.5, 0.4);
  off.flags = rt::kDriveThoughTilted;
  bench.ask(2.0, off);
  CHECK(bench.stop() == 0);
  CHECK(bench.has(kDriveTilted));
  const UgvDriveOutput& out = bench.drive.output();
  const double belt = std::fabs(out.speed_m_s) + 0.2 * std::fabs(out.turn_rad_s);
  CHECK(belt == Approx(bench.config.recover_speed_m_s));
  CHECK(out.turn_rad_s / out.speed_m_s == Approx(0.4 / -0.5));
  bench.robot.roll = 0.59;
  bench.ask(1.0, off);
  CHECK_FALSE(bench.has(kDriveTilted));
  CHECK(bench.drive.output().stops.tilted == 1);  // one tilt, whoever drove
}

TEST_CASE("The wait at the start holds everything back") {
  UgvDriveConfig config = usual();
  config.start_wait_ns = 2 * rt::kNanosecondsPerSecond;
  Bench bench(config);
  const Waypoint far[] = {{10, 0}};
  REQUIRE(bench.drive.set_route(far) == Status::ok);
  bench.run(1.0);
  CHECK(bench.stop() == kStopStarting);
  CHECK(bench.stands());
  bench.ask(0.9, request_of(0.3));
  CHECK(bench.stop() == kStopStarting);
  CHECK(bench.stands());
  bench.ask(1.0, request_of(0.3));
  CHECK(bench.drive.output().speed_m_s > 0.1);
  CHECK(bench.drive.output().stops.starting == 1);
}

TEST_CASE("Time must go forward, and a pause makes no jump") {
  Bench bench = on_the_road();
  const rt::PoseEstimate pose = bench.robot.pose(bench.now_ns);
  CHECK(bench.drive.update(pose, {}, bench.now_ns) == Status::time_repeated);
  CHECK(bench.drive.update(pose, {}, bench.now_ns - 1) == Status::time_backwards);
  const double before = bench.drive.output().speed_m_s;
  bench.now_ns += 3600 * rt::kNanosecondsPerSecond;
  CHECK(bench.drive.update(bench.robot.pose(bench.now_ns), {true, false}, bench.now_ns) == Status::ok);
  CHECK(bench.drive.output().speed_m_s >= before - bench.config.stop.acceleration * 32 * 0.005 - 1e-9);
}

TEST_CASE("Limits that may change keep the stop the firmer one and the speeds on their ramps") {
  Bench bench = on_the_road();
  CHECK(bench.drive.set_max_acceleration(1.5) == Status::out_of_range);  // the stop has 1.0
  CHECK(bench.drive.set_max_acceleration(0) == Status::out_of_range);
  CHECK(bench.drive.set_max_speed(-1) == Status::out_of_range);
  CHECK(bench.drive.set_max_speed(kNan) == Status::out_of_range);
  CHECK(bench.drive.set_max_turn_rate(0) == Status::out_of_range);
  CHECK(bench.drive.set_track_width(0) == Status::out_of_range);
  REQUIRE(bench.drive.set_max_speed(0.2) == Status::ok);
  bench.run(3.0);
  CHECK(bench.drive.output().speed_m_s == Approx(0.2));
  REQUIRE(bench.drive.set_track_width(0.8) == Status::ok);
  bench.ask(2.0, request_of(0.1, 0.2));
  CHECK(bench.drive.output().right_m_s - bench.drive.output().left_m_s == Approx(0.8 * 0.2));
}

TEST_CASE("A drive that is put back in the middle goes on as if it had never stopped") {
  UgvDriveConfig config = usual();
  config.follower.stuck_s = 1.0;
  Draw draw(8);
  Bench bench(config);
  const Waypoint route[] = {{2, 0}, {2, 2}, {0, 0}};
  REQUIRE(bench.drive.set_route(route) == Status::ok);
  for (int leg = 0; leg < 60; ++leg) {
    bench.robot.held = draw.one_in(4);
    bench.robot.roll = draw.one_in(6) ? 0.8 : 0.0;
    if (draw.one_in(6)) {
      rt::DriveRequest request = request_of(draw(-0.5, 0.5), draw(-1, 1));
      request.posture = static_cast<std::int32_t>(draw(0, 3.99));
      bench.ask(0.2, request);
    }
    if (draw.one_in(4)) bench.ask(0.05, request_of(0, 0, rt::DriveMode::release));
    if (draw.one_in(4)) {
      rt::DriveRequest late = request_of(0.1, 0);
      late.counter = bench.drive.output().request_counter + 1;
      late.stamp_ns = bench.now_ns - 60 * rt::kNanosecondsPerSecond;
      REQUIRE(bench.drive.request(late, bench.now_ns) == Status::stale);
    }
    bench.run(draw(0.1, 1.5), {draw.one_in(8), false});
    rt::Archive count = rt::Archive::measuring();
    bench.drive.archive(count);
    INFO(count.where() << ": " << count.why());
    REQUIRE(count.status() == Status::ok);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(count.bytes()));
    rt::Archive out = rt::Archive::writing(bytes);
    bench.drive.archive(out);
    REQUIRE(out.status() == Status::ok);
    UgvDrive twin(config);
    REQUIRE(twin.set_route(route) == Status::ok);
    rt::Archive in = rt::Archive::reading(bytes);
    twin.archive(in);
    REQUIRE(in.status() == Status::ok);
    CHECK(twin.output().requests.held_back == bench.drive.output().requests.held_back);
    for (int i = 0; i < 20; ++i) {
      bench.now_ns += kStep_ns;
      const rt::PoseEstimate pose = bench.robot.pose(bench.now_ns);
      REQUIRE(twin.update(pose, {}, bench.now_ns) == Status::ok);
      REQUIRE(bench.step_with(pose) == Status::ok);
      std::uint8_t mine[rt::canonical_size<UgvDriveOutput>()];
      std::uint8_t its[sizeof mine];
      rt::encode_canonical(bench.drive.output(), mine);
      rt::encode_canonical(twin.output(), its);
      REQUIRE(std::memcmp(mine, its, sizeof mine) == 0);
    }
  }
  CHECK(bench.drive.output().requests.held_back > 0);
}
