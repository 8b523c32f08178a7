// SPDX-License-Identifier: BSD-3-Clause
// Lidar of 64 rows, rolling laser and solid-state lidar: rays where closed forms and per-ray poses put them.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>

#include "hil/lidar_model.hpp"
#include "hil/rolling_laser.hpp"
#include "hil/ssl_sensor.hpp"
#include "oracle.hpp"
#include "tests/hil/sensor_bench.hpp"

namespace sortie::hil {
namespace {

constexpr double kDegreeInRad = kPi / 180.0;

// A closed room: inner faces at x = +-5, y = +-4, floor 0, ceiling 3.
World closed_room() {
  World world;
  const auto add = [&world](const BoxShape& shape) { REQUIRE(world.add(make_box(shape)) == Status::ok); };
  add({5.5, 0, 0, 1, 20, 0, 4});
  add({-5.5, 0, 0, 1, 20, 0, 4});
  add({0, 4.5, 0, 20, 1, 0, 4});
  add({0, -4.5, 0, 20, 1, 0, 4});
  add({0, 0, 0, 20, 20, 3, 4});
  REQUIRE(world.finalize() == Status::ok);
  return world;
}

double room_range(const Vec3& p, const Vec3& d) {
  const double x = d.x != 0.0 ? ((d.x > 0 ? 5.0 : -5.0) - p.x) / d.x : 1e300;
  const double y = d.y != 0.0 ? ((d.y > 0 ? 4.0 : -4.0) - p.y) / d.y : 1e300;
  const double z = d.z != 0.0 ? ((d.z > 0 ? 3.0 : 0.0) - p.z) / d.z : 1e300;
  return std::fmin(x, std::fmin(y, z));
}

// A rotation with libm, as a matrix applied to a vector: yaw, pitch, roll.
Vec3 turned(const Vec3& v, double yaw, double pitch, double roll) {
  const Vec3 a{v.x, std::cos(roll) * v.y - std::sin(roll) * v.z, std::sin(roll) * v.y + std::cos(roll) * v.z};
  const Vec3 b{std::cos(pitch) * a.x + std::sin(pitch) * a.z, a.y,
               -std::sin(pitch) * a.x + std::cos(pitch) * a.z};
  return {std::cos(yaw) * b.x - std::sin(yaw) * b.y, std::sin(yaw) * b.x + std::cos(yaw) * b.y, b.z};
}

RangeNoiseConfig exact_ranges() {
  RangeNoiseConfig noise;
  noise.sigma_m = 0.0;
  noise.loss = 0.0;
  return noise;
}

template <class Config>
void tilt_mount(Config& config) {
  const double place[3] = {0.1, -0.05, 0.6};
  const double turn[3] = {0.4, 0.15, -0.1};
  for (int i = 0; i < 3; ++i) {
    config.mount_m[i] = place[i];
    config.mount_ypr_rad[i] = turn[i];
  }
}

LidarConfig exact_rows_64(std::uint32_t columns) {
  LidarConfig config = make_rows_64(3);
  config.columns = columns;
  config.noise = exact_ranges();
  config.keep_truth = true;
  tilt_mount(config);
  return config;
}

RollingLaserConfig exact_rolling() {
  RollingLaserConfig config;
  config.beams = 181;
  config.noise = exact_ranges();
  config.keep_truth = true;
  tilt_mount(config);
  return config;
}

Vec3 as_vector(const rt::ScanPoint& p) {
  return {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)};
}

// The pose at a time within steps of one millisecond.
BodyInstant body_then(rt::Nanoseconds stamp_ns) {
  const rt::Nanoseconds begin = (stamp_ns - 1) / kMs * kMs;
  BodyInstant body;
  REQUIRE(body_at(moving_step(begin), stamp_ns, body) == Status::ok);
  return body;
}

}  // namespace

TEST_CASE("a lidar of 64 rows at rest measures a room as its closed form has it, to 1e-9 m") {
  const World world = closed_room();
  const LidarConfig config = exact_rows_64(256);
  LidarModel lidar(config, {}, 1, 0);
  oracle::KeepingSink sink;
  const Vec3 place{0.7, -0.4, 0.2};
  for (int i = 0; i < 100; ++i)
    lidar.advance(RayCaster(world), resting_step(i * kMs, place, from_yaw_pitch_roll(0.5, 0.05, 0.1)), sink);
  REQUIRE(sink.scans.size() == 1);
  const auto& points = sink.scans[0].points;
  REQUIRE(points.size() == 64 * 256);  // the room is closed
  REQUIRE(lidar.truth().size() == points.size());
  const Vec3 sensor = place + turned({0.1, -0.05, 0.6}, 0.5, 0.05, 0.1);
  double worst = 0.0;
  double worst_point = 0.0;
  std::size_t k = 0;
  for (std::uint32_t c = 0; c < 256; ++c) {
    for (std::uint32_t r = 0; r < 64; ++r, ++k) {
      const double azimuth = (2.0 * (c + 1) / 256.0 - 1.0) * kPi + config.row_azimuth_rad[r];
      const double up = config.row_elevation_rad[r];
      const Vec3 ray{std::cos(up) * std::cos(azimuth), std::cos(up) * std::sin(azimuth), std::sin(up)};
      const Vec3 in_body = turned(ray, 0.4, 0.15, -0.1);
      const double expected = room_range(sensor, turned(in_body, 0.5, 0.05, 0.1));
      worst = std::fmax(worst, std::fabs(lidar.truth()[k].range_m - expected));
      worst_point = std::fmax(worst_point, norm(as_vector(points[k]) - expected * ray));
    }
  }
  CHECK(worst < 1e-9);
  CHECK(worst_point < 1e-6);  // points are floats
  // Rows are staggered as four columns of lasers, and calibrated by device.
  CHECK(config.row_azimuth_rad[0] == Approx(3.164 * kDegreeInRad).margin(0.031 * kDegreeInRad));
  CHECK(config.row_azimuth_rad[3] == Approx(-3.164 * kDegreeInRad).margin(0.031 * kDegreeInRad));
  CHECK(config.row_elevation_rad[0] > config.row_elevation_rad[63]);
  CHECK(make_rows_64(3).row_elevation_rad == config.row_elevation_rad);
  CHECK(make_rows_64(4).row_elevation_rad != config.row_elevation_rad);
}

TEST_CASE("rays of a moving lidar of 64 rows are those cast from each column's own pose") {
  const World world = sensor_yard();
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  const RayCaster caster(world, &shell);
  LidarConfig config = exact_rows_64(200);
  config.mount_m[2] = 0.4;  // low enough to see the flippers
  config.min_range_m = 0.1;
  const SensorMount mount = make_mount(config.mount_m, config.mount_ypr_rad);
  LidarModel lidar(config, {}, 1, 0);
  oracle::KeepingSink sink;
  for (int i = 0; i < 200; ++i) lidar.advance(caster, moving_step(i * kMs), sink);
  REQUIRE(sink.scans.size() == 2);
  REQUIRE(lidar.truth().size() == sink.scans[1].points.size());
  const auto& scan = sink.scans[1];
  std::size_t k = 0;
  double frozen = 0.0;
  int own = 0;
  RayCaster::Aim at_end;
  REQUIRE(caster.aim(mount, body_then(scan.header.stamp_ns), at_end) == Status::ok);
  for (std::uint32_t c = 0; c < 200; ++c) {
    const rt::Nanoseconds at = 100 * kMs + (c + 1) * 100 * kMs / 200;
    RayCaster::Aim aim;
    REQUIRE(caster.aim(mount, body_then(at), aim) == Status::ok);
    for (std::uint32_t r = 0; r < 64; ++r) {
      const Vec3 ray = lidar.direction(c, r);
      const RangeHit hit = caster.cast_brute_force(aim, ray, config.max_range_m);
      if (!hit || hit.range_m < config.min_range_m) continue;
      REQUIRE(k < scan.points.size());
      REQUIRE(lidar.truth()[k].range_m == hit.range_m);
      REQUIRE(lidar.truth()[k].solid == hit.solid);
      REQUIRE(scan.points[k].age_10us == (200 * kMs - at) / 10'000);
      REQUIRE(scan.points[k].x_m == static_cast<float>(hit.range_m * ray.x));
      const RangeHit still = caster.cast(at_end, ray, config.max_range_m);
      if (still.solid == hit.solid) frozen = std::fmax(frozen, std::fabs(still.range_m - hit.range_m));
      own += hit.own() ? 1 : 0;
      ++k;
    }
  }
  CHECK(k == scan.points.size());
  CHECK(frozen > 0.1);  // the motion within a turn is really in the ranges
  CHECK(own > 100);
}

TEST_CASE("a rolling laser at rest measures a room as its closed form has it, to 1e-9 m") {
  const World world = closed_room();
  RollingLaserConfig config = exact_rolling();
  config.encoder_ticks = 1u << 20;
  RollingLaser laser(config, {}, 1, 0);
  oracle::KeepingSink sink;
  const Vec3 place{0.7, -0.4, 0.2};
  std::uint64_t line = 0;
  double worst = 0.0;
  double worst_point = 0.0;
  std::size_t rays = 0;
  for (int i = 0; i < 3600; ++i) {
    const std::size_t before = sink.scans.size();
    laser.advance(RayCaster(world), resting_step(i * kMs, place, from_yaw_pitch_roll(0.5, 0.05, 0.1)), sink);
    if (sink.scans.size() == before) continue;
    const auto& scan = sink.scans.back();
    REQUIRE(scan.points.size() == laser.truth().size());
    const Vec3 sensor = place + turned({0.1, -0.05, 0.6}, 0.5, 0.05, 0.1);
    std::size_t k = 0;
    for (int l = 0; l < 5; ++l, ++line) {
      for (std::uint32_t b = 0; b < config.beams; ++b) {
        // 20 ms a line, of which the laser looks out for three quarters; one turn of the mount in 3.6 s.
        const double even_ns = 2e7 * static_cast<double>(line) + 1.5e7 * (b + 1) / config.beams;
        const auto at_ns = static_cast<double>(laser.beam_ns(line, b));
        REQUIRE(std::fabs(at_ns - even_ns) <= 1.0);
        const double roll = 2 * kPi * at_ns / 3.6e9;
        const double across = (b / (config.beams - 1.0) - 0.5) * 1.5 * kPi;
        const Vec3 ray{std::cos(across), std::cos(roll) * std::sin(across),
                       std::sin(roll) * std::sin(across)};
        const double expected = room_range(sensor, turned(turned(ray, 0.4, 0.15, -0.1), 0.5, 0.05, 0.1));
        REQUIRE(expected > config.min_range_m);
        REQUIRE(k < scan.points.size());
        worst = std::fmax(worst, std::fabs(laser.truth()[k].range_m - expected));
        worst_point = std::fmax(worst_point, norm(as_vector(scan.points[k]) - expected * ray));
        ++k;
      }
    }
    rays += k;
    CHECK(scan.header.stamp_ns == static_cast<rt::Nanoseconds>(line) * 20'000'000);
  }
  CHECK(rays == 180 * config.beams);
  CHECK(worst < 1e-9);
  CHECK(worst_point < 4e-5);  // a tick of the encoder is 6e-6 rad
}

TEST_CASE("rays of a moving rolling laser are those cast from each beam's own pose and angle") {
  const World world = sensor_yard();
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  const RayCaster caster(world, &shell);
  RollingLaserConfig config = exact_rolling();
  config.encoder_ticks = 512;
  config.line_hz = 30;  // does not divide a second
  const SensorMount mount = make_mount(config.mount_m, config.mount_ypr_rad);
  RollingLaser laser(config, {}, 1, 0);
  oracle::KeepingSink sink;
  std::size_t scans = 0;
  std::size_t points = 0;
  double turned_off = 0.0;
  for (int i = 0; i < 1000; ++i) {
    laser.advance(caster, moving_step(i * kMs), sink);
    if (sink.scans.size() == scans) continue;
    const auto& scan = sink.scans.back();
    std::size_t k = 0;
    for (std::uint64_t line = 5 * scans; line < 5 * (scans + 1); ++line) {
      for (std::uint32_t b = 0; b < config.beams; ++b) {
        const rt::Nanoseconds at = laser.beam_ns(line, b);
        const RollAngle roll = laser.roll_at(at);
        RayCaster::Aim aim;
        REQUIRE(caster.aim(mount, body_then(at), aim) == Status::ok);
        const RangeHit hit =
            caster.cast_brute_force(aim, laser.direction(b, roll.true_rad), config.max_range_m);
        if (!hit || hit.range_m < config.min_range_m) continue;
        REQUIRE(k < scan.points.size());
        REQUIRE(laser.truth()[k].range_m == hit.range_m);
        REQUIRE(laser.truth()[k].solid == hit.solid);
        REQUIRE(scan.points[k].age_10us == (scan.header.stamp_ns - at) / 10'000);
        // The point lies where the encoder believed the ray to go.
        REQUIRE(scan.points[k].y_m ==
                static_cast<float>(hit.range_m * laser.direction(b, roll.measured_rad).y));
        REQUIRE(std::fabs(roll.measured_rad - roll.true_rad) <= kPi / 512 + 1e-12);
        turned_off = std::fmax(turned_off, std::fabs(roll.measured_rad - roll.true_rad));
        ++k;
      }
    }
    REQUIRE(k == scan.points.size());
    CHECK(scan.header.stamp_ns == static_cast<rt::Nanoseconds>(5 * (scans + 1)) * 1'000'000'000 / 30);
    points += k;
    ++scans;
  }
  CHECK(scans == 6);
  CHECK(points > 3000);
  CHECK(turned_off > 0.9 * kPi / 512);
}

TEST_CASE("the rolling mount turns evenly, and its encoder counts every tick once a turn") {
  const RollingLaser laser(exact_rolling(), {}, 1, 0);
  std::set<std::uint32_t> ticks;
  for (rt::Nanoseconds at = 0; at < 7'200'000'000; at += 400'001) {
    const RollAngle roll = laser.roll_at(at);
    ticks.insert(roll.ticks);
    REQUIRE(roll.ticks < 4096);
    REQUIRE(std::remainder(roll.true_rad - 2 * kPi * static_cast<double>(at) / 3.6e9, 2 * kPi) ==
            Approx(0.0).margin(1e-9));
  }
  CHECK(ticks.size() == 4096);
}

TEST_CASE("a solid-state lidar fires what it is told, at the pose of each ray, and says so in order") {
  const World world = sensor_yard();
  const RayCaster caster(world);
  SslConfig config;
  config.enabled = true;
  config.noise = exact_ranges();
  tilt_mount(config);
  const SensorMount mount = make_mount(config.mount_m, config.mount_ypr_rad);
  SslSensor sensor(config, {}, 1, 0);
  drivers::SslStub link;
  Random random(91, 1);
  INFO("seed 91");
  rt::Nanoseconds now = 0;
  int nothing = 0;
  for (std::uint32_t number = 1; number <= 30; ++number) {
    rt::SslCommand command;
    command.number = number;
    command.rays = number % 7 == 0 ? number % 2 : 1 + static_cast<std::uint32_t>(random.uniform() * 255.9);
    for (std::uint32_t i = 0; i < command.rays; ++i)
      command.direction[i] = static_cast<std::uint16_t>(random.uniform() * rt::kSslDirections);
    REQUIRE(link.send(command) == Status::ok);
    const rt::Nanoseconds begin = now;
    rt::SslReturns returns;
    for (int i = 0; i < 20; ++i, now += kMs) {
      REQUIRE(link.receive(returns) == Status::empty);
      sensor.advance(caster, moving_step(now), link);
    }
    REQUIRE(link.receive(returns) == Status::ok);
    REQUIRE(returns.stamp_ns == begin + 20 * kMs);
    REQUIRE(returns.number == number);
    REQUIRE(returns.rays == command.rays);
    REQUIRE(sensor.truth().size() == command.rays);
    for (std::uint32_t i = 0; i < returns.rays; ++i) {
      const std::uint32_t direction = command.direction[i];
      REQUIRE(returns.direction[i] == direction);
      const double azimuth = (-60 + 120 * (direction % 160) / 159.0) * kDegreeInRad;
      const double up = (-45 + 90 * (direction / 160) / 119.0) * kDegreeInRad;
      const Vec3 ray{std::cos(up) * std::cos(azimuth), std::cos(up) * std::sin(azimuth), std::sin(up)};
      const rt::Nanoseconds at = begin + 20 * kMs * (i + 1) / returns.rays;
      REQUIRE(returns.age_10us[i] == (begin + 20 * kMs - at) / 10'000);
      RayCaster::Aim aim;
      REQUIRE(caster.aim(mount, body_then(at), aim) == Status::ok);
      const RangeHit hit = caster.cast_brute_force(aim, ray, 48.0);
      if (!hit || hit.range_m < 0.3) {
        ++nothing;
        REQUIRE(returns.range_mm[i] == 0);
        continue;
      }
      REQUIRE(sensor.truth()[i].range_m == Approx(hit.range_m).margin(1e-9));
      REQUIRE(sensor.measured_m()[i] == sensor.truth()[i].range_m);
      REQUIRE(std::fabs(1e-3 * returns.range_mm[i] - hit.range_m) <= 0.0005 + 1e-9);
    }
  }
  CHECK(nothing > 100);
  CHECK(sensor.counters().frames == 30);
}

TEST_CASE(
    "rays to fire that cannot be are refused, and those that wait are fired one frame after the other") {
  const World world = sensor_yard();
  SslConfig config;
  config.enabled = true;
  SslSensor sensor(config, {}, 1, 0);
  drivers::SslStub link;
  rt::SslCommand command;
  command.rays = 300;
  CHECK(link.send(command) == Status::out_of_range);
  command.rays = 1;
  command.direction[0] = rt::kSslDirections;
  CHECK(link.send(command) == Status::out_of_range);
  command.direction[0] = 5;
  for (std::uint32_t i = 1; i <= 4; ++i) {
    command.number = i;
    CHECK(link.send(command) == Status::ok);
  }
  CHECK(link.send(command) == Status::full);
  rt::SslReturns returns;
  for (int i = 0; i < 100; ++i) {
    sensor.advance(RayCaster(world), resting_step(i * kMs, {}), link);
    if (link.receive(returns) != Status::ok) continue;
    CHECK(returns.stamp_ns == static_cast<rt::Nanoseconds>(returns.number) * 20 * kMs);
  }
  CHECK(returns.number == 4);
  CHECK(sensor.counters().frames == 4);
}

}  // namespace sortie::hil
