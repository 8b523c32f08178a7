// SPDX-License-Identifier: BSD-3-Clause
// A solid-state lidar: the rays that it is told to fire, where per-ray poses put them.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>

#include "hil/ssl_sensor.hpp"
#include "tests/hil/exact_ranges.hpp"

namespace sortie::hil {

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
