// SPDX-License-Identifier: BSD-3-Clause
// A rolling laser: beams where closed forms and per-beam poses put them.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>

#include "hil/rolling_laser.hpp"
#include "tests/hil/exact_ranges.hpp"

namespace sortie::hil {
namespace {

RollingLaserConfig exact_rolling() {
  RollingLaserConfig config;
  config.beams = 181;
  config.noise = exact_ranges();
  config.keep_truth = true;
  tilt_mount(config);
  return config;
}

}  // namespace

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

}  // namespace sortie::hil
