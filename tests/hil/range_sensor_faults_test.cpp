// SPDX-License-Identifier: BSD-3-Clause
// Range sensors where something is wrong: lost scans and frames, poses that are none, the robot in its own
// way, values at the end of their range. And no heap.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>

#include "hil/lidar_model.hpp"
#include "hil/rolling_laser.hpp"
#include "hil/ssl_sensor.hpp"
#include "oracle.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/hil/sensor_bench.hpp"

namespace sortie::hil {
namespace {

LidarConfig small_rows_64() {
  LidarConfig config = make_rows_64(1);
  config.columns = 100;
  config.keep_truth = true;
  return config;
}

RollingLaserConfig small_rolling() {
  RollingLaserConfig config;
  config.beams = 91;
  config.keep_truth = true;
  return config;
}

SslConfig enabled_ssl() {
  SslConfig config;
  config.enabled = true;
  return config;
}

rt::SslCommand forty_rays(std::uint32_t number) {
  rt::SslCommand command;
  command.number = number;
  command.rays = 40;
  for (std::uint32_t i = 0; i < 40; ++i) command.direction[i] = static_cast<std::uint16_t>(i * 480 + 80);
  return command;
}

// A sink with one buffer, so that nothing is taken from the heap.
class OneBufferSink final : public drivers::ScanSink {
 public:
  rt::ScanPoint* reserve(std::uint32_t capacity) noexcept override {
    return capacity <= points_.size() ? points_.data() : nullptr;
  }
  Status commit(const rt::ScanHeader& header) noexcept override {
    points += header.points;
    return Status::ok;
  }
  void cancel() noexcept override {}
  std::uint64_t points{};

 private:
  std::vector<rt::ScanPoint> points_ = std::vector<rt::ScanPoint>(8192);
};

}  // namespace

TEST_CASE("a pose that is none gives no point, is counted by ray, and leaves later noise as it was") {
  const World world = sensor_yard();
  const RayCaster caster(world);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  oracle::KeepingSink rows_sinks[2];
  oracle::KeepingSink rolling_sinks[2];
  for (int broken = 0; broken < 2; ++broken) {
    LidarModel lidar(small_rows_64(), {}, 1, 0);
    RollingLaser laser(small_rolling(), {}, 1, 0);
    SslSensor ssl(enabled_ssl(), {}, 1, 0);
    drivers::SslStub link;
    REQUIRE(link.send(forty_rays(1)) == Status::ok);
    for (int i = 0; i < 100; ++i) {
      SensorStep step = moving_step(i * kMs);
      if (broken == 1 && i == 10) step.after.p_world_body_m.y = nan;
      lidar.advance(caster, step, rows_sinks[broken]);
      laser.advance(caster, step, rolling_sinks[broken]);
      ssl.advance(caster, step, link);
    }
    CHECK(lidar.ranges().refused == (broken == 1 ? 64u : 0u));
    CHECK(lidar.ranges().rays == 6400);
    CHECK(laser.ranges().refused == (broken == 1 ? 6u : 0u));
    CHECK(ssl.ranges().refused == (broken == 1 ? 2u : 0u));
    rt::SslReturns returns;
    REQUIRE(link.receive(returns) == Status::ok);
    if (broken == 1) CHECK((returns.range_mm[20] == 0 && returns.range_mm[21] == 0));
  }
  // The points of all other columns are the same: whole has them all, broken the rest.
  const auto& whole = rows_sinks[0].scans.at(0).points;
  const auto& rest = rows_sinks[1].scans.at(0).points;
  REQUIRE(rest.size() < whole.size());
  REQUIRE(rest.size() >= whole.size() - 64);
  std::size_t k = 0;
  for (const rt::ScanPoint& point : whole) {
    if (k < rest.size() && point.x_m == rest[k].x_m && point.z_m == rest[k].z_m) ++k;
  }
  CHECK(k == rest.size());
  for (const auto& sink : rows_sinks) {
    for (const rt::ScanPoint& point : sink.scans.at(0).points)
      REQUIRE(std::isfinite(static_cast<double>(point.x_m + point.y_m + point.z_m)));
  }
}

TEST_CASE("scans and frames are lost as often as asked, and the others are as they would have been") {
  const World world = sensor_yard();
  const RayCaster caster(world);
  FaultConfig faults;
  faults.drop = 0.3;
  oracle::KeepingSink whole;
  oracle::KeepingSink lossy;
  RollingLaserConfig config = small_rolling();
  config.lines_per_scan = 1;
  RollingLaser a(config, {}, 5, 0);
  RollingLaser b(config, faults, 5, 0);
  SslConfig ssl_config = enabled_ssl();
  ssl_config.frame_ns = kMs;
  SslSensor ssl(ssl_config, faults, 5, 0);
  drivers::SslStub link;
  int answers = 0;
  rt::SslReturns returns;
  for (int i = 0; i < 10000; ++i) {
    const SensorStep step = moving_step(i * kMs);
    a.advance(caster, step, whole);
    b.advance(caster, step, lossy);
    rt::SslCommand command = forty_rays(static_cast<std::uint32_t>(i));
    command.rays = 1;
    REQUIRE(link.send(command) == Status::ok);
    ssl.advance(caster, step, link);
    answers += link.receive(returns) == Status::ok ? 1 : 0;
  }
  REQUIRE(whole.scans.size() == 500);
  INFO("seed 5");
  CHECK(b.counters().dropped == 500 - lossy.scans.size());
  CHECK(static_cast<double>(lossy.scans.size()) == Approx(350).margin(4.0 * std::sqrt(500 * 0.21)));
  CHECK(answers == Approx(7000).margin(4.0 * std::sqrt(10000 * 0.21)));
  CHECK(ssl.counters().dropped == static_cast<std::uint64_t>(10000 - answers));
  std::size_t k = 0;
  for (const auto& scan : whole.scans) {
    if (k == lossy.scans.size() || lossy.scans[k].header.stamp_ns != scan.header.stamp_ns) continue;
    REQUIRE(lossy.scans[k].points.size() == scan.points.size());
    for (std::size_t i = 0; i < scan.points.size(); ++i)
      REQUIRE(lossy.scans[k].points[i].x_m == scan.points[i].x_m);
    ++k;
  }
  CHECK(k == lossy.scans.size());
}

TEST_CASE(
    "the robot is seen by its own sensors where that is switched on, and flippers move in the picture") {
  const World world = sensor_yard();
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  RollingLaserConfig config = small_rolling();
  config.min_range_m = 0.05;
  config.roll_period_ns = 170 * kMs;
  const auto own_points = [&](bool seen, double flipper_rad) {
    RollingLaser laser(config, {}, 1, 0);
    oracle::KeepingSink sink;
    for (int i = 0; i < 500; ++i) {
      SensorStep step = resting_step(i * kMs, {});
      for (int f = 0; f < kFlippers; ++f)
        step.before_flipper_rad[f] = step.after_flipper_rad[f] = flipper_rad;
      laser.advance(RayCaster(world, seen ? &shell : nullptr), step, sink);
    }
    CHECK((laser.ranges().own > 0) == seen);
    return laser.ranges().own;
  };
  CHECK(own_points(false, 0.0) == 0);
  const std::uint64_t flat = own_points(true, 0.0);
  const std::uint64_t raised = own_points(true, 1.2);
  CHECK(flat > 100);
  CHECK(raised > flat);  // raised flippers stand in the view
}

TEST_CASE("an intensity beyond 16 bits is the largest, and a clock that jumps shifts every stamp") {
  World world;
  REQUIRE(world.add(make_box({5, 0, 0, 1, 20, 0, 9}, 65535)) == Status::ok);
  REQUIRE(world.finalize() == Status::ok);
  FaultConfig faults;
  faults.jump_at_ns = 0;
  faults.jump_ns = 7 * kMs;
  LidarModel lidar(small_rows_64(), faults, 1, 0);
  SslSensor ssl(enabled_ssl(), faults, 1, 0);
  drivers::SslStub link;
  REQUIRE(link.send(forty_rays(1)) == Status::ok);
  oracle::KeepingSink sink;
  for (int i = 0; i < 100; ++i) {
    lidar.advance(RayCaster(world), resting_step(i * kMs, {}), sink);
    ssl.advance(RayCaster(world), resting_step(i * kMs, {}), link);
  }
  REQUIRE(sink.scans.size() == 1);
  CHECK(sink.scans[0].header.stamp_ns == 107 * kMs);
  std::uint16_t brightest = 0;
  for (const rt::ScanPoint& point : sink.scans[0].points) brightest = std::max(brightest, point.intensity);
  CHECK(brightest > 65000);
  rt::SslReturns returns;
  REQUIRE(link.receive(returns) == Status::ok);
  CHECK(returns.stamp_ns == 27 * kMs);
}

TEST_CASE("sensors take nothing from the heap while they run") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: this build cannot count heap calls");
    return;
  }
  const auto world = std::make_unique<World>(sensor_yard());
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  const RayCaster caster(*world, &shell);
  LidarModel lidar(small_rows_64(), {}, 1, 0);
  RollingLaser laser(small_rolling(), {}, 1, 0);
  SslSensor ssl(enabled_ssl(), {}, 1, 0);
  auto link = std::make_unique<drivers::SslStub>();
  OneBufferSink sink;
  bool sent = true;
  rt::SslReturns returns;
  const rt::posix::HeapTrapScope scope;
  for (int i = 0; i < 300; ++i) {
    if (i % 20 == 0) sent = sent && link->send(forty_rays(static_cast<std::uint32_t>(i))) == Status::ok;
    const SensorStep step = moving_step(i * kMs);
    lidar.advance(caster, step, sink);
    laser.advance(caster, step, sink);
    ssl.advance(caster, step, *link);
    static_cast<void>(link->receive(returns));
  }
  CHECK(scope.calls() == 0);
  CHECK(sent);
  CHECK(sink.points > 10000);
  CHECK(ssl.counters().frames == 15);
}

TEST_CASE("a laser that cannot be says which setting to change") {
  RollingLaserConfig config;
  config.lines_per_scan = 40;  // 0.8 s
  CHECK_THROWS_WITH(RollingLaser(config, {}, 1, 0), Catch::Contains("lines_per_scan"));
  config = {};
  config.encoder_ticks = 0;
  CHECK_THROWS_WITH(RollingLaser(config, {}, 1, 0), Catch::Contains("encoder_ticks"));
  config = {};
  config.roll_period_ns = 0;
  CHECK_THROWS_WITH(RollingLaser(config, {}, 1, 0), Catch::Contains("roll_period_ns"));
  LidarConfig rows = make_rows_64(1);
  rows.row_elevation_rad[9] = 2.0;
  CHECK_THROWS_WITH(LidarModel(rows, {}, 1, 0), Catch::Contains("row_elevation_rad"));
}

}  // namespace sortie::hil
