// SPDX-License-Identifier: BSD-3-Clause
// Routes driven to their end by a robot that slips, turns less than it should and knows its place badly;
// forward, in reverse, and against something that holds it.
#include "planner/waypoint_follower.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/planner/drive_twin.hpp"

using namespace sortie;
using namespace sortie::planner;
using namespace sortie::planner::test;

namespace {

double away(const Robot& robot, const Waypoint& w) { return std::hypot(w.x_m - robot.x, w.y_m - robot.y); }

/// A route with corners of all kinds, at least `apart` from point to point.
std::vector<Waypoint> random_route(Draw& draw, std::size_t points, double apart) {
  std::vector<Waypoint> route;
  Waypoint last{0, 0};
  while (route.size() < points) {
    const Waypoint w{draw(-5, 5), draw(-5, 5)};
    if (std::hypot(w.x_m - last.x_m, w.y_m - last.y_m) < apart) continue;
    route.push_back(last = w);
  }
  return route;
}

double length_of(const std::vector<Waypoint>& route) {
  double way = 0;
  Waypoint last{0, 0};
  for (const Waypoint& w : route) {
    way += std::hypot(w.x_m - last.x_m, w.y_m - last.y_m);
    last = w;
  }
  return way;
}

}  // namespace

TEST_CASE("Routes are driven past every waypoint with slip from 1.0 down to 0.6, lag and a noisy pose",
          "[heavy]") {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    INFO("seed " << seed);
    Draw draw(seed);
    Bench bench;
    bench.robot.turn_share = draw(0.6, 1.0);
    bench.robot.grip = draw(0.6, 1.0);
    bench.robot.lag_s = draw(0.02, 0.1);
    const std::vector<Waypoint> route = random_route(draw, 6, 0.3);
    REQUIRE(bench.drive.set_route(route) == Status::ok);
    std::vector<double> nearest(route.size(), 1e9);
    const double patience_s = 3.0 * length_of(route) / bench.config.max_speed_m_s / 0.6 + 6 * 12.0;
    double moved_x = 0, moved_y = 0;  // noise of the pose that wanders and jumps a little
    while (!bench.has(kDriveDone) || !bench.stands()) {
      bench.now_ns += kStep_ns;
      REQUIRE(rt::to_seconds(bench.now_ns) < patience_s);
      moved_x = 0.99 * moved_x + draw(-0.001, 0.001);
      moved_y = 0.99 * moved_y + draw(-0.001, 0.001);
      rt::PoseEstimate pose = bench.robot.pose(bench.now_ns);
      pose.p_world_body_m[0] += moved_x + draw(-0.01, 0.01);
      pose.p_world_body_m[1] += moved_y + draw(-0.01, 0.01);
      rt::store(rt::from_yaw_pitch_roll(bench.robot.heading + draw(-0.02, 0.02), draw(-0.02, 0.02), 0),
                pose.q_world_body);
      REQUIRE(bench.step_with(pose) == Status::ok);
      REQUIRE(bench.drive.output().speed_m_s >= -1e-12);
      for (std::size_t i = 0; i < route.size(); ++i)
        nearest[i] = std::min(nearest[i], away(bench.robot, route[i]));
    }
    REQUIRE(bench.good);
    for (std::size_t i = 0; i < route.size(); ++i) {
      INFO("waypoint " << i);
      CHECK(nearest[i] <= bench.config.follower.reach_radius_m + 0.03);
    }
    CHECK(bench.drive.follower().reached == route.size());
    CHECK(bench.drive.follower().stuck == 0);
    CHECK(away(bench.robot, route.back()) <= bench.config.follower.reach_radius_m + 0.03);
  }
}

TEST_CASE("A waypoint close behind is driven to in reverse, a far one is turned to") {
  UgvDriveConfig config = usual();
  config.follower.reverse_m = 2.0;
  Bench bench(config);
  const Waypoint back_and_forth[] = {{1.5, 0}, {0.2, 0.1}, {1.5, 0}, {-2.5, 0}};
  REQUIRE(bench.drive.set_route(back_and_forth) == Status::ok);
  bool reversed[4]{};
  double most_heading = 0;
  while (!bench.has(kDriveDone) || !bench.stands()) {
    REQUIRE(bench.now_ns < 60 * rt::kNanosecondsPerSecond);
    bench.run(0.005);
    const std::uint32_t leg = bench.drive.output().waypoint;
    if (leg < 4 && bench.has(kDriveReversing)) reversed[leg] = true;
    if (leg < 3) most_heading = std::max(most_heading, std::fabs(bench.robot.heading));
  }
  CHECK_FALSE(reversed[0]);
  CHECK(reversed[1]);
  CHECK_FALSE(reversed[2]);
  CHECK_FALSE(reversed[3]);
  CHECK(most_heading < 0.5);
  CHECK(away(bench.robot, back_and_forth[3]) <= 0.15);
}

TEST_CASE(
    "A robot that is held stops, backs off, tries again, and at last stays until it is told otherwise") {
  UgvDriveConfig config = usual();
  config.follower.stuck_s = 2.0;
  config.follower.stuck_tries = 2;
  Bench bench(config);
  const Waypoint ahead[] = {{3, 0}};
  REQUIRE(bench.drive.set_route(ahead) == Status::ok);
  bench.run(2.0);
  bench.robot.held = true;
  const double wall_m = bench.robot.x;
  double least_x = wall_m;
  for (int i = 0; i < 8000; ++i) {
    bench.run(0.005);
    least_x = std::min(least_x, bench.robot.x);
  }
  CHECK(bench.stop() == kStopStuck);
  CHECK(bench.stands());
  CHECK(bench.drive.output().stops.stuck == 3);
  CHECK(bench.drive.follower().backed_off == 2);
  CHECK(least_x < wall_m - 0.25);  // it has driven back
  CHECK(least_x > wall_m - 0.75);  // about twice 0.3 m
  bench.run(20);
  CHECK(bench.stop() == kStopStuck);
  // Free again, and told so.
  bench.robot.held = false;
  bench.ask(0.05, request_of(0, 0, rt::DriveMode::release));
  bench.run(30);
  CHECK(bench.has(kDriveDone));
  CHECK(bench.stop() == 0);
}

TEST_CASE("A robot that gets free while it backs off reaches its goal by itself") {
  UgvDriveConfig config = usual();
  config.follower.stuck_s = 2.0;
  Bench bench(config);
  const Waypoint ahead[] = {{3, 0}};
  REQUIRE(bench.drive.set_route(ahead) == Status::ok);
  bench.run(1.0);
  bench.robot.held = true;
  while (bench.drive.follower().backed_off == 0) {
    REQUIRE(bench.now_ns < 60 * rt::kNanosecondsPerSecond);
    bench.run(0.005);
  }
  bench.robot.held = false;
  bench.run(30);
  CHECK(bench.has(kDriveDone));
  CHECK(bench.drive.output().stops.stuck == 1);
}

TEST_CASE("A bad route is refused and the old one stays, waypoints in one place are all reached at once") {
  WaypointFollower follower(WaypointFollowerConfig{});
  const std::vector<Waypoint> most(64, Waypoint{1, 1});
  const std::vector<Waypoint> too_many(65, Waypoint{1, 1});
  CHECK(follower.set_route(most) == Status::ok);
  CHECK(follower.set_route(too_many) == Status::full);
  const Waypoint nan[] = {{std::nan(""), 0}};
  CHECK(follower.set_route(nan) == Status::not_finite);
  const Waypoint far[] = {{0, 1e7}};
  CHECK(follower.set_route(far) == Status::out_of_range);
  CHECK_FALSE(follower.done());
  WaypointFollowerConfig config;
  config.repeat = true;
  WaypointFollower round(config);
  const std::vector<Waypoint> here(64, Waypoint{0, 0});
  CHECK(round.set_route(here) == Status::ok);
  static_cast<void>(round.wish(Robot{}.pose(kStep_ns), {}, {}, kStep_ns));
  CHECK(round.counters().reached == 64);
  CHECK_FALSE(round.done());
}

TEST_CASE("A drive without a route is done at once and enables nothing") {
  Bench bench;
  bench.run(1.0);
  CHECK(bench.has(kDriveDone));
  CHECK_FALSE(bench.has(kDriveEnabled));
  CHECK(bench.stands());
}
