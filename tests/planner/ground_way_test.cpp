// SPDX-License-Identifier: BSD-3-Clause
// A robot that is told where to go in yards that it has not seen: where it drives, and whether it arrives.
#include "planner/ground_way/ground_way_planner.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/planner/ground_yard.hpp"

using namespace sortie;
using namespace sortie::planner;
using namespace sortie::planner::test;

namespace {

struct YardRun {
  bool arrived{};
  bool fell{};
  double off_m{};
  double seconds{};
  GroundWayState state{};
};

YardRun drive_yard(const Yard& yard, double goal_x_m, double goal_y_m, std::uint64_t seed, double most_s) {
  YardRobot robot(yard, seed);
  REQUIRE(robot.planner.usable());
  robot.goal_x_m = goal_x_m;
  robot.goal_y_m = goal_y_m;
  YardRun run;
  while (run.seconds < most_s && !robot.follower.arrived() && !run.fell) {
    robot.job();
    run.seconds += 0.1;
    run.fell = !yard.carries(robot.x_m, robot.y_m, robot.yaw, 0.11);
  }
  run.arrived = robot.follower.arrived();
  run.off_m = std::hypot(robot.x_m - goal_x_m, robot.y_m - goal_y_m);
  run.state = static_cast<GroundWayState>(robot.planner.output().state);
  return run;
}

/// A way exists for somebody who knows all of the yard: over cells of 5 cm, for a disc around the robot.
bool is_reachable(const Yard& yard, double goal_x_m, double goal_y_m) {
  // Whoever fits with 0.85 m turns anywhere: 0.63 m to the corner of what is planned with, 0.07 m from the
  // middle of a cell, 0.1 m for the cell that an edge takes, 0.05 m for one of the yard.
  constexpr int kReach = 17;
  const int n = Yard::kCells;
  std::vector<char> open(static_cast<std::size_t>(n) * static_cast<std::size_t>(n), 1);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      if (std::abs(yard.height[static_cast<std::size_t>(y * n + x)]) < 0.01) continue;
      for (int dy = -kReach; dy <= kReach; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx)
          if (dx * dx + dy * dy <= kReach * kReach && x + dx >= 0 && y + dy >= 0 && x + dx < n && y + dy < n)
            open[static_cast<std::size_t>((y + dy) * n + x + dx)] = 0;
    }
  std::vector<int> reached{Yard::cell_of(0.01) * n + Yard::cell_of(0.01)};
  if (open[static_cast<std::size_t>(reached[0])] == 0) return false;
  open[static_cast<std::size_t>(reached[0])] = 2;
  while (!reached.empty()) {
    const int at = reached.back();
    reached.pop_back();
    for (const int by : {1, -1, n, -n}) {
      const int next = at + by;
      if (next < 0 || next >= n * n || open[static_cast<std::size_t>(next)] != 1) continue;
      open[static_cast<std::size_t>(next)] = 2;
      reached.push_back(next);
    }
  }
  return open[static_cast<std::size_t>(Yard::cell_of(goal_y_m) * n + Yard::cell_of(goal_x_m))] == 2;
}

struct YardCounts {
  int runs{};
  int fell{};
  int reachable{};
  int arrived{};
  int there{};  // arrived of those reachable
};

YardCounts drive_yards(std::uint64_t first, int runs) {
  YardCounts counts;
  for (int i = 0; i < runs; ++i) {
    const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
    std::mt19937_64 random(seed);
    const Yard yard = draw_yard(random);
    const auto place = [&random] { return -4.0 + 8.0 * static_cast<double>(random() >> 11) * 0x1p-53; };
    const double x_m = place();
    const double y_m = place();
    const bool is_open = is_reachable(yard, x_m, y_m);
    const YardRun run = drive_yard(yard, x_m, y_m, seed, 120.0);
    ++counts.runs;
    counts.fell += run.fell ? 1 : 0;
    counts.reachable += is_open ? 1 : 0;
    counts.arrived += run.arrived ? 1 : 0;
    counts.there += run.arrived && is_open ? 1 : 0;
    if (run.fell || (is_open && !run.arrived))
      WARN("seed " << seed << (run.fell ? " fell" : " did not arrive") << ", state "
                   << static_cast<int>(run.state) << ", " << run.off_m << " m off after " << run.seconds);
    if (run.arrived) CHECK(run.off_m < 0.2);
  }
  UNSCOPED_INFO("runs " << counts.runs << " fell " << counts.fell << " reachable " << counts.reachable
                        << " of those there " << counts.there << " arrived " << counts.arrived);
  return counts;
}

}  // namespace

TEST_CASE("ground way: in drawn yards no robot drives where nothing carries it, and it arrives", "[heavy]") {
  const char* const first = std::getenv("SORTIE_YARD_SEED");
  const char* const trials = std::getenv("SORTIE_YARD_TRIALS");
  const YardCounts counts = drive_yards(first != nullptr ? std::strtoull(first, nullptr, 10) : 4'100'000,
                                        trials != nullptr ? std::atoi(trials) : 24);
  CHECK(counts.fell == 0);
  CHECK(counts.there == counts.reachable);
  if (trials != nullptr)
    WARN("runs " << counts.runs << " fell " << counts.fell << " reachable " << counts.reachable
                 << " of those there " << counts.there << " arrived " << counts.arrived);
}

TEST_CASE("ground way: a goal behind a wall without a door is refused, and the robot stands") {
  Yard yard;
  yard.put(-5, -4.8, -5, 5, 2);
  yard.put(4.8, 5, -5, 5, 2);
  yard.put(-5, 5, -5, -4.8, 2);
  yard.put(-5, 5, 4.8, 5, 2);
  yard.put(1.5, 1.7, -5, 5, 2);
  const YardRun run = drive_yard(yard, 3.0, 0.0, 1, 90.0);
  CHECK(!run.fell);
  CHECK(!run.arrived);
  CHECK(run.state == GroundWayState::none);
}

TEST_CASE("ground way: a cliff at the nose is not driven over, a step of a hand's breadth neither",
          "[heavy]") {
  for (const double z : {-3.0, -1.0, -0.3, -0.12, 0.12, 0.3}) {
    Yard yard;
    yard.put(1.3, 5.0, -5.0, 5.0, z);
    const YardRun run = drive_yard(yard, 3.0, 0.0, 2, 60.0);
    CAPTURE(z);
    CHECK(!run.fell);
    CHECK(!run.arrived);
  }
}

TEST_CASE("ground way: told a goal with its nose at a drop, a kerb or a wall, it does not go over that",
          "[heavy]") {
  // The edge lies from under the nose to a hand's breadth in front of it, the goal behind it.
  for (const double z : {-2.0, -0.3, -0.15, 0.15, 1.0}) {
    for (const double edge_m : {0.42, 0.45, 0.5, 0.55, 0.6, 0.7}) {
      Yard yard;
      yard.put(edge_m, 5.0, -5.0, 5.0, z);
      const YardRun run = drive_yard(yard, 2.0, 0.0, 3, 15.0);
      CAPTURE(z, edge_m);
      CHECK(!run.fell);
      CHECK(!run.arrived);
    }
  }
}

TEST_CASE("ground way: a goal where the robot stands is reached at once") {
  Yard yard;
  const YardRun run = drive_yard(yard, 0.0, 0.0, 4, 10.0);
  CHECK(run.arrived);
}

TEST_CASE("ground way: pushed off its way the robot begins anew from where it stands") {
  Yard yard;
  yard.put(-1.2, -1.0, -5.0, 5.0, 1.0);
  YardRobot robot(yard);
  robot.goal_x_m = 3.0;
  for (int i = 0; i < 40; ++i) robot.job();
  REQUIRE(robot.follower.has_way(robot.now_ns));
  const std::uint32_t series = robot.planner.output().series;
  robot.y_m += 0.6;
  robot.yaw += 1.0;
  bool fell = false;
  for (int i = 0; i < 600 && !robot.follower.arrived(); ++i) {
    robot.job();
    fell = fell || !yard.carries(robot.x_m, robot.y_m, robot.yaw, 0.11);
  }
  CHECK(!fell);
  CHECK(robot.follower.arrived());
  CHECK(robot.planner.output().series > series);
  CHECK(robot.planner.output().lost >= 1);
}

TEST_CASE("ground way: without pose or goal nothing is handed out, and what is not finite is refused") {
  Yard yard;
  YardRobot robot(yard);
  robot.goal_x_m = 2.0;
  for (int i = 0; i < 20; ++i) robot.job();
  REQUIRE(robot.planner.output().steps > 1);
  rt::PoseEstimate pose = robot.pose();
  GroundWayProgress progress{1, {2.0, 0.0}, 1, 1, true, false, false};
  pose.p_world_body_m[1] = std::nan("");
  CHECK(robot.planner.begin(robot.map.view(), pose, true, progress, robot.now_ns, robot.now_ns) ==
        Status::not_finite);
  robot.planner.end();
  CHECK(robot.planner.output().steps == 0);
  for (int i = 0; i < 20; ++i) robot.job();
  REQUIRE(robot.planner.output().steps > 1);
  pose = robot.pose();
  CHECK(robot.planner.begin(robot.map.view(), pose, true, progress, robot.now_ns + rt::kNanosecondsPerSecond,
                            robot.now_ns + rt::kNanosecondsPerSecond) == Status::stale);
  robot.planner.end();
  CHECK(robot.planner.output().steps == 0);
  // The lidar is silent: the pose is of now, the heights are not. And somebody else drives.
  for (const bool is_silent : {true, false}) {
    for (int i = 0; i < 20; ++i) robot.job();
    REQUIRE(robot.planner.output().steps > 1);
    progress.in_control = is_silent;
    const rt::Nanoseconds heights_ns = robot.now_ns - (is_silent ? 2 : 0) * rt::kNanosecondsPerSecond;
    CHECK(robot.planner.begin(robot.map.view(), robot.pose(), true, progress, heights_ns, robot.now_ns) ==
          (is_silent ? Status::stale : Status::ok));
    robot.planner.end();
    CHECK(robot.planner.output().steps == 0);
    progress.in_control = true;
  }
  pose = robot.pose();
  progress.goal_m[0] = std::numeric_limits<double>::infinity();
  CHECK(robot.planner.begin(robot.map.view(), pose, true, progress, robot.now_ns, robot.now_ns) ==
        Status::not_finite);
  progress = {};
  CHECK(robot.planner.begin(robot.map.view(), pose, true, progress, robot.now_ns, robot.now_ns) ==
        Status::ok);
  robot.planner.end();
  CHECK(robot.planner.output().state == static_cast<std::uint32_t>(GroundWayState::idle));
  CHECK(!robot.planner.works());
}

TEST_CASE("ground way: one that is restored in the middle of a plan goes on as the one that was not") {
  std::mt19937_64 random(4'200'001);
  const Yard yard = draw_yard(random);
  YardRobot one(yard, 5, 7);  // so few slices that plans take several jobs
  one.goal_x_m = 3.0;
  one.goal_y_m = -3.0;
  int restored = 0;
  for (int i = 0; i < 400; ++i) {
    if (i % 13 == 12 && one.planner.works()) {
      rt::Archive measuring = rt::Archive::measuring();
      measuring.value(one.planner);
      REQUIRE(measuring.status() == Status::ok);
      std::vector<std::uint8_t> bytes(measuring.bytes());
      rt::Archive out = rt::Archive::writing(bytes);
      out.value(one.planner);
      REQUIRE(out.status() == Status::ok);
      std::vector<std::byte> memory(std::size_t{24} << 20);
      rt::Arena arena(memory);
      GroundWayPlanner fresh(YardRobot::way(), one.map.config().cell_mm, arena);
      rt::Archive in = rt::Archive::reading(bytes);
      in.value(fresh);
      REQUIRE(in.status() == Status::ok);
      // The same job in both: all that is put out is the same.
      one.now_ns += 1;
      const GroundWayProgress progress{1,     {3.0, -3.0}, one.follower.series(), one.follower.step(), true,
                                       false, false};
      for (GroundWayPlanner* planner : {&one.planner, &fresh}) {
        static_cast<void>(
            planner->begin(one.map.view(), one.pose(), false, progress, one.now_ns, one.now_ns));
        for (int k = 0; planner->works() && k < 40; ++k) planner->step();
        planner->end();
      }
      const GroundWay& a = one.planner.output();
      const GroundWay& b = fresh.output();
      CHECK(a.steps == b.steps);
      CHECK(a.plan == b.plan);
      CHECK(a.plans == b.plans);
      CHECK(std::equal(std::begin(a.x_mm), std::end(a.x_mm), std::begin(b.x_mm)));
      CHECK(std::equal(std::begin(a.y_mm), std::end(a.y_mm), std::begin(b.y_mm)));
      CHECK(one.planner.works() == fresh.works());
      ++restored;
    }
    one.job();
  }
  CHECK(restored >= 5);
}
