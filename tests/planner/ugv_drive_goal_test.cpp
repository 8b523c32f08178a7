// SPDX-License-Identifier: BSD-3-Clause
// A drive that is told a place to go to: who is in control, what stops it, and when it is done.
#include <catch2/catch.hpp>

#include "planner/ground_way/ground_way_follower.hpp"
#include "tests/planner/drive_twin.hpp"

using namespace sortie;
using namespace sortie::planner;
using namespace sortie::planner::test;

namespace {

UgvDriveConfig with_ways() {
  UgvDriveConfig config = usual();
  config.finds_ways = true;
  return config;
}

UgvDriveInputs guided(double speed_m_s, double turn_rad_s = 0.0) {
  UgvDriveInputs inputs;
  inputs.guide.has_way = true;
  inputs.guide.wish = {speed_m_s, turn_rad_s};
  return inputs;
}

Status ask_go(Bench& bench, double x_m, double y_m, std::int64_t counter = 0) {
  rt::DriveRequest request = request_of(0, 0, rt::DriveMode::go);
  request.goal_x_m = x_m;
  request.goal_y_m = y_m;
  request.counter = counter != 0 ? counter : bench.drive.output().request_counter + 1;
  request.stamp_ns = bench.now_ns;
  return bench.drive.request(request, bench.now_ns);
}

}  // namespace

TEST_CASE("A goal takes over from the route, and without a way the robot stands") {
  Bench bench = on_the_road(with_ways());
  REQUIRE(ask_go(bench, 3, -2) == Status::ok);
  bench.run(3.0);
  CHECK(bench.source() == DriveSource::goal);
  CHECK(bench.stop() == kStopNoWay);
  CHECK(bench.stands());
  CHECK(bench.drive.output().goal == 1);
  CHECK(bench.drive.output().goal_x_m == 3);
  CHECK(bench.drive.output().goal_y_m == -2);
  CHECK(bench.drive.output().stops.no_way == 1);
  bench.run(2.0, guided(0.2, 0.1));
  CHECK(bench.stop() == 0);
  CHECK(bench.drive.output().speed_m_s == Approx(0.2));
  bench.run(2.0);  // the way has gone
  CHECK(bench.stop() == kStopNoWay);
  CHECK(bench.stands());
  UgvDriveInputs there = guided(0.2);
  there.guide.arrived = true;
  there.guide.has_way = false;
  bench.run(2.0, there);
  CHECK(bench.has(kDriveDone));
  CHECK(bench.stop() == 0);
  CHECK(bench.stands());
  CHECK(!bench.has(kDriveWanted));
  bench.ask(0.05, request_of(0, 0, rt::DriveMode::release));  // back to the route
  bench.run(2.0);
  CHECK(bench.source() == DriveSource::route);
  CHECK(bench.drive.output().goal == 0);
  CHECK(!bench.stands());
}

TEST_CASE("A goal ends no halt, requests rank above it, and a release hands control back to it") {
  Bench bench = on_the_road(with_ways());
  bench.ask(1.0, request_of(0, 0, rt::DriveMode::halt));
  REQUIRE(ask_go(bench, 3, -2) == Status::ok);
  bench.run(2.0, guided(0.2));
  CHECK((bench.stop() & kStopHalt) != 0);
  CHECK(bench.stands());
  const std::uint32_t asked = bench.drive.output().asked;
  bench.ask(0.05, request_of(0, 0, rt::DriveMode::release));
  bench.run(2.0, guided(0.2));
  CHECK(bench.source() == DriveSource::goal);
  CHECK(bench.drive.output().asked == asked + 1);
  CHECK(bench.drive.output().speed_m_s == Approx(0.2));
  bench.ask(1.0, request_of(-0.1));
  CHECK(bench.source() == DriveSource::remote);
  bench.ask(0.05, request_of(0, 0, rt::DriveMode::release));
  bench.run(1.0, guided(0.2));
  CHECK(bench.source() == DriveSource::goal);
  // A new goal in the place of the old one: its number rises, so that no way to the old one counts.
  REQUIRE(ask_go(bench, 5, 5) == Status::ok);
  bench.run(0.1, guided(0.2));
  CHECK(bench.drive.output().goal == 2);
  REQUIRE(ask_go(bench, 5, 5) == Status::ok);  // the same again
  bench.run(0.1, guided(0.2));
  CHECK(bench.drive.output().goal == 2);
}

TEST_CASE("A place that is none is refused, and all of them by a robot that finds no ways") {
  Bench bench = on_the_road(with_ways());
  CHECK(ask_go(bench, kNan, 0) == Status::not_finite);
  CHECK(ask_go(bench, 0, 1e9) == Status::out_of_range);
  CHECK(ask_go(bench, 1, 1) == Status::ok);
  CHECK(ask_go(bench, 1, 1, 1) == Status::time_repeated);
  CHECK(bench.drive.set_goal(kNan, 0) == Status::not_finite);
  CHECK(bench.drive.set_goal(1e9, 0) == Status::out_of_range);
  Bench other = on_the_road();
  CHECK(ask_go(other, 1, 1) == Status::not_supported);
  other.run(1.0);
  CHECK(other.source() == DriveSource::route);
}

TEST_CASE("A way's follower drives forward, turns and reverses along it, and stands without one") {
  GroundWay way;
  way.goal = 1;
  way.series = 1;
  const auto add = [&way](WayMotion motion, int x_mm, int y_mm, int mrad) {
    way.x_mm[way.steps] = x_mm;
    way.y_mm[way.steps] = y_mm;
    way.heading_mrad[way.steps] = static_cast<std::int16_t>(mrad);
    way.motion[way.steps++] = static_cast<std::uint8_t>(motion);
  };
  add(WayMotion::begin, 0, 0, 0);
  add(WayMotion::forward, 1000, 0, 0);
  add(WayMotion::turn, 1000, 0, 785);
  add(WayMotion::turn, 1000, 0, 1571);
  add(WayMotion::forward, 1000, 1500, 1571);
  add(WayMotion::reverse, 1000, 500, 1571);
  way.whole = 1;
  GroundWayFollower follower({});
  double x = 0.02;
  double y = -0.03;
  double yaw = 0.1;
  double most_y = 0;
  double beside = 0;
  bool reversed = false;
  rt::Nanoseconds now_ns = rt::kNanosecondsPerSecond;
  const auto step = [&] {
    now_ns += 20 * rt::kNanosecondsPerMillisecond;
    rt::PoseEstimate pose;
    pose.flags = 1;
    rt::store(rt::Vector3{x, y, 0}, pose.p_world_body_m);
    rt::store(rt::from_yaw_pitch_roll(yaw, 0, 0), pose.q_world_body);
    const SpeedTurn wish =
        follower.has_way(now_ns) ? follower.wish(pose, {0.3, 0.6, 0.6, 0.2}, {}, now_ns) : SpeedTurn{};
    x += 0.02 * wish.speed_m_s * std::cos(yaw);
    y += 0.02 * wish.speed_m_s * std::sin(yaw);
    yaw += 0.02 * wish.turn_rad_s;
    return wish;
  };
  CHECK(!follower.has_way(now_ns));
  for (int i = 0; i < 3000 && !follower.arrived(); ++i) {
    way.stamp_ns = now_ns;
    follower.take(way, 1);
    const SpeedTurn wish = step();
    reversed = reversed || wish.speed_m_s < 0;
    most_y = std::max(most_y, y);
    beside = std::max(beside, y < 0.1 ? std::fabs(y) : std::fabs(x - 1.0));
  }
  CHECK(follower.arrived());
  CHECK(reversed);
  CHECK(most_y > 1.4);
  CHECK(x == Approx(1.0).margin(0.07));
  CHECK(y == Approx(0.5).margin(0.07));
  CHECK(beside < 0.12);
  // A way of another goal, and one that nobody renews.
  GroundWayFollower other({});
  other.take(way, 2);
  CHECK(!other.has_way(now_ns));
  other.take(way, 1);
  CHECK(other.has_way(way.stamp_ns));
  CHECK(!other.has_way(way.stamp_ns + 1001 * rt::kNanosecondsPerMillisecond));
  // Pushed off it the robot stands.
  follower.forget();
  ++way.series;
  way.stamp_ns = now_ns;
  x = 0.5;
  y = 0.4;
  follower.take(way, 1);
  CHECK(step().speed_m_s == 0.0);
  CHECK(follower.lost());
  CHECK(follower.counters().off == 1);
}
