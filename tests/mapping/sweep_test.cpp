// SPDX-License-Identifier: BSD-3-Clause
// Sweeps taken while the robot moves, against rooms whose walls are known in closed form.
#include "mapping/grid/sweep.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "rt/posix/heap_trap.hpp"

namespace sortie::mapping {
namespace {

constexpr double kRoomX_m = 9.0;  // walls at +-x and +-y
constexpr double kRoomY_m = 4.0;
constexpr double kPi_rad = 3.14159265358979323846;

// Drives on a circle and nods: the body's pose at a time, in closed form.
struct Drive {
  double speed_m_s{0.3};
  double turn_rad_s{0.5};
  double nod_rad{0.02};

  StampedPose at(rt::Nanoseconds stamp_ns) const {
    const double t = static_cast<double>(stamp_ns) * 1e-9;
    const double yaw = turn_rad_s * t;
    const double radius = turn_rad_s != 0.0 ? speed_m_s / turn_rad_s : 0.0;
    StampedPose pose;
    pose.stamp_ns = stamp_ns;
    pose.p = turn_rad_s != 0.0 ? rt::Vector3{radius * std::sin(yaw), radius * (1.0 - std::cos(yaw)), 0.1}
                               : rt::Vector3{speed_m_s * t, 0.0, 0.1};
    pose.q = rt::from_yaw_pitch_roll(yaw, nod_rad * std::sin(7.0 * t), 0.5 * nod_rad * std::sin(5.0 * t));
    return pose;
  }
};

SweepConfig mount() {
  SweepConfig config;
  config.p_body_sensor_m = {0.2, -0.1, 0.45};
  config.q_body_sensor = rt::from_yaw_pitch_roll(0.3, -0.1, 0.05);
  config.min_range_m = 0.3;
  config.max_range_m = 60.0;
  return config;
}

RigidPose sensor_at(const SweepConfig& config, const StampedPose& body) {
  return {body.p + rt::rotate(body.q, config.p_body_sensor_m), body.q * config.q_body_sensor};
}

double wall_distance(const rt::Vector3& p) {
  return std::min(std::abs(std::abs(p.x) - kRoomX_m), std::abs(std::abs(p.y) - kRoomY_m));
}

// One turn of a spinning lidar: a return per column, each from where the sensor is at its own time.
std::vector<rt::ScanPoint> spin(const SweepConfig& config, const Drive& drive, rt::Nanoseconds end_ns,
                                int columns) {
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < columns; ++i) {
    const auto age = static_cast<std::uint16_t>((columns - 1 - i) * 10000 / columns);
    const RigidPose sensor = sensor_at(config, drive.at(end_ns - 10'000 * rt::Nanoseconds{age}));
    const double angle = 2.0 * kPi_rad * i / columns;
    const rt::Vector3 ray{std::cos(angle), std::sin(angle), 0.02 * (i % 7 - 3)};
    const rt::Vector3 d = rt::rotate(sensor.q, ray);
    const rt::Vector3& o = sensor.p;
    const double to_x = d.x != 0.0 ? ((d.x > 0 ? kRoomX_m : -kRoomX_m) - o.x) / d.x : 1e9;
    const double to_y = d.y != 0.0 ? ((d.y > 0 ? kRoomY_m : -kRoomY_m) - o.y) / d.y : 1e9;
    const double t = std::min(to_x, to_y);
    points.push_back({static_cast<float>(t * ray.x), static_cast<float>(t * ray.y),
                      static_cast<float>(t * ray.z), 7, age});
  }
  return points;
}

rt::PointScan view(const std::vector<rt::ScanPoint>& points, rt::Nanoseconds stamp_ns) {
  rt::PointScan scan;
  scan.header.stamp_ns = stamp_ns;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return scan;
}

double worst_wall(const StraightSweep& sweep) {
  double worst = 0.0;
  for (std::uint32_t i = 0; i < sweep.scan.header.points; ++i) {
    const rt::ScanPoint& p = sweep.scan.points[i];
    const rt::Vector3 world =
        sweep.pose.p + rt::rotate(sweep.pose.q, {static_cast<double>(p.x_m), static_cast<double>(p.y_m),
                                                 static_cast<double>(p.z_m)});
    worst = std::max(worst, wall_distance(world));
  }
  return worst;
}

// Poses each 10 ms until `newest_ns`.
void feed(Sweeps& sweeps, const Drive& drive, rt::Nanoseconds newest_ns) {
  for (rt::Nanoseconds t = std::max<rt::Nanoseconds>(0, newest_ns - 600'000'000); t <= newest_ns;
       t += 10'000'000)
    REQUIRE(sweeps.add(drive.at(t)) == Status::ok);
}

}  // namespace

TEST_CASE("sweep: walls seen while the robot turns stay thin") {
  const SweepConfig config = mount();
  const Drive drive;
  std::vector<rt::ScanPoint> memory(2048);
  Sweeps sweeps(config, memory);
  REQUIRE(sweeps.usable() == Status::ok);
  const rt::Nanoseconds end_ns = 1'000'000'000;
  feed(sweeps, drive, end_ns);
  auto points = spin(config, drive, end_ns, 1024);
  const StraightSweep straight = sweeps.straighten(view(points, end_ns));
  REQUIRE(straight.status == Status::ok);
  CHECK(straight.counts.used == 1024);
  CHECK(worst_wall(straight) <
        1e-4);  // poses 10 ms apart on a curve: the chord is off by 4 um, the nod by 60 um at 9 m
  // The same sweep as if it had been taken in one moment: what straightening is for.
  for (rt::ScanPoint& p : points) p.age_10us = 0;
  CHECK(worst_wall(sweeps.straighten(view(points, end_ns))) > 0.2);
}

TEST_CASE(
    "sweep: the newest pose is behind the sweep's end, and walls stay within a centimetre of their place") {
  const SweepConfig config = mount();
  const Drive drive;
  const rt::Nanoseconds end_ns = 1'000'000'000;
  const auto points = spin(config, drive, end_ns, 1024);
  const auto worst_with_poses_until = [&](rt::Nanoseconds newest_ns) {
    std::vector<rt::ScanPoint> memory(2048);
    Sweeps sweeps(config, memory);
    feed(sweeps, drive, newest_ns);
    const StraightSweep straight = sweeps.straighten(view(points, end_ns));
    REQUIRE(straight.status == Status::ok);
    return worst_wall(straight);
  };
  CHECK(worst_with_poses_until(end_ns - 10'000'000) < 0.01);
  CHECK(worst_with_poses_until(end_ns - 20'000'000) < 0.01);
}

TEST_CASE("sweep: what has no pose is counted, and the rest goes on") {
  SweepConfig config = mount();
  const Drive drive;
  std::vector<rt::ScanPoint> memory(2048);
  Sweeps sweeps(config, memory);
  const auto points = spin(config, drive, 1'000'000'000, 1000);
  CHECK(sweeps.straighten(view(points, 1'000'000'000)).status == Status::empty);
  // Poses from 950 ms on: half of the sweep's 100 ms is older.
  for (rt::Nanoseconds t = 950'000'000; t <= 1'000'000'000; t += 10'000'000)
    REQUIRE(sweeps.add(drive.at(t)) == Status::ok);
  const StraightSweep half = sweeps.straighten(view(points, 1'000'000'000));
  CHECK(half.status == Status::ok);
  CHECK(half.counts.unplaced == Approx(499).margin(1));
  CHECK(half.counts.used == 1000 - half.counts.unplaced);
  CHECK(worst_wall(half) < 1e-4);
  const StraightSweep ahead = sweeps.straighten(view(points, 1'200'000'000));
  CHECK(ahead.status == Status::out_of_range);
  CHECK(ahead.counts.unplaced == 1000);
  CHECK(sweeps.straighten(view(points, 900'000'000)).status == Status::stale);
  CHECK(sweeps.counts().in == 4000);
  CHECK(sweeps.counts().in == sweeps.counts().used + sweeps.counts().unplaced);
}

TEST_CASE("sweep: returns that are no use are counted by reason, and the sensor's clock is corrected") {
  SweepConfig config = mount();
  config.robot.boxes[0] = {{0, 0, 0.1}, {0.4, 0.3, 0.1}};
  config.robot.box_count = 1;
  config.max_range_m = 5.0;
  config.time_offset_ns = -30'000'000;
  const Drive drive;
  std::vector<rt::ScanPoint> memory(3);
  Sweeps sweeps(config, memory);
  feed(sweeps, drive, 1'000'000'000);
  // On the robot: the middle of its box as the sensor sees it.
  const rt::Vector3 own =
      rt::rotate_back(config.q_body_sensor, rt::Vector3{0, 0, 0.0} - config.p_body_sensor_m);
  const std::vector<rt::ScanPoint> points{
      {std::nanf(""), 0, 0, 0, 0},
      {0.1f, 0, 0, 0, 0},
      {0, 6.0f, 0, 0, 0},
      {static_cast<float>(own.x), static_cast<float>(own.y), static_cast<float>(own.z), 0, 0},
      {3.4e38f, 3.4e38f, 0, 0, 0},
      {2, 0, 1, 1, 0},
      {2, 0, 1, 2, 100},
      {2, 0, 1, 3, 200},
      {2, 0, 1, 4, 300}};
  const StraightSweep sweep = sweeps.straighten(view(points, 1'000'000'000));
  CHECK(sweep.counts.not_finite == 1);
  CHECK(sweep.counts.too_near == 1);
  CHECK(sweep.counts.too_far == 2);
  CHECK(sweep.counts.on_robot == 1);
  CHECK(sweep.counts.scan_full == 1);
  CHECK(sweep.counts.used == 3);
  const RigidPose expected = sensor_at(config, drive.at(970'000'000));
  CHECK(rt::norm(sweep.pose.p - expected.p) < 1e-12);
  CHECK(sweep.scan.points[0].intensity == 1);
  CHECK(sweep.scan.header.stamp_ns == 1'000'000'000);
}

TEST_CASE("sweep: settings that cannot be are refused") {
  std::vector<rt::ScanPoint> memory(4);
  const auto usable = [&](auto change) {
    SweepConfig config = mount();
    change(config);
    return Sweeps(config, memory).usable();
  };
  CHECK(usable([](SweepConfig&) {}) == Status::ok);
  CHECK(usable([](SweepConfig& c) { c.q_body_sensor = {2, 0, 0, 0}; }) == Status::out_of_range);
  CHECK(usable([](SweepConfig& c) { c.p_body_sensor_m.x = std::nan(""); }) == Status::out_of_range);
  CHECK(usable([](SweepConfig& c) { c.max_range_m = 0.1; }) == Status::out_of_range);
  CHECK(usable([](SweepConfig& c) { c.max_ahead_ns = -1; }) == Status::out_of_range);
  CHECK(Sweeps(mount(), {}).usable() == Status::out_of_range);
  Sweeps sweeps(mount(), memory);
  CHECK(sweeps.set_ranges(2, 1) == Status::out_of_range);
  CHECK(sweeps.set_ranges(1, 2) == Status::ok);
}

TEST_CASE("sweep: no heap, and a keyframe carries it on to the bit") {
  const SweepConfig config = mount();
  const Drive drive;
  std::vector<rt::ScanPoint> memory(2048);
  std::vector<rt::ScanPoint> other_memory(2048);
  Sweeps sweeps(config, memory);
  feed(sweeps, drive, 1'000'000'000);
  const double flippers_rad[rt::kFlippers] = {0, 0.7};
  REQUIRE(sweeps.set_flippers(flippers_rad) == Status::ok);
  const auto points = spin(config, drive, 1'000'000'000, 1024);
  if (rt::posix::kHeapTrapAvailable) {
    std::uint64_t calls = 0;
    {
      const rt::posix::HeapTrapScope scope;
      static_cast<void>(sweeps.straighten(view(points, 1'000'000'000)));
      calls = scope.calls();
    }
    CHECK(calls == 0);
  }
  rt::Archive measure = rt::Archive::measuring();
  sweeps.archive(measure);
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  sweeps.archive(write);
  Sweeps copy(config, other_memory);
  rt::Archive read = rt::Archive::reading(bytes);
  copy.archive(read);
  REQUIRE(read.status() == Status::ok);
  CHECK(copy.counts().in == sweeps.counts().in);
  static_cast<void>(sweeps.straighten(view(points, 1'000'000'000)));
  static_cast<void>(copy.straighten(view(points, 1'000'000'000)));
  for (std::size_t i = 0; i < 1024; ++i) REQUIRE(memory[i].x_m == other_memory[i].x_m);
}

}  // namespace sortie::mapping
