// SPDX-License-Identifier: BSD-3-Clause
// Every range sensor with every error switched on, to the bit: what it gives must not depend on compiler,
// optimisation or processor.
#include <bit>
#include <catch2/catch.hpp>

#include "hil/lidar_model.hpp"
#include "hil/rolling_laser.hpp"
#include "hil/ssl_sensor.hpp"
#include "oracle.hpp"
#include "tests/hil/sensor_bench.hpp"

namespace sortie::hil {
namespace {

struct RangeDigest {
  std::uint64_t value{0xcbf29ce484222325u};
  void add(std::uint64_t bits) { value = (value ^ bits) * 0x100000001b3u; }
  void add(const oracle::KeepingSink& sink) {
    for (const auto& scan : sink.scans) {
      add(static_cast<std::uint64_t>(scan.header.stamp_ns));
      for (const rt::ScanPoint& p : scan.points) {
        add(std::bit_cast<std::uint32_t>(p.x_m));
        add(std::bit_cast<std::uint32_t>(p.y_m));
        add(std::bit_cast<std::uint32_t>(p.z_m));
        add(p.intensity);
        add(p.age_10us);
      }
    }
  }
};

// As moving_step(), without libm.
SensorStep portable_step(int ms) {
  SensorStep step;
  for (int end = 0; end < 2; ++end) {
    Motion& motion = end == 0 ? step.before : step.after;
    const double t = 0.001 * (ms + end);
    motion.stamp_ns = (ms + end) * kMs;
    motion.p_world_body_m = {0.9 * t, rt::sin(0.7 * t), 0.1 + 0.02 * rt::sin(6.0 * t)};
    motion.q_world_body = from_yaw_pitch_roll(0.6 * t, 0.1 * rt::sin(3.0 * t), 0.05 * rt::cos(4.0 * t));
    for (int f = 0; f < kFlippers; ++f)
      (end == 0 ? step.before_flipper_rad : step.after_flipper_rad)[f] = rt::sin(t + f);
  }
  return step;
}

RangeNoiseConfig every_error() {
  RangeNoiseConfig noise;
  noise.sigma_share = 0.002;
  noise.bias_m = 0.01;
  noise.resolution_m = 0.002;
  noise.loss = 0.02;
  noise.graze_cos = 0.2;
  noise.full_range_m = 5.0;
  noise.divergence_rad = 0.004;
  noise.stamp_jitter_ns = 20'000;
  return noise;
}

}  // namespace

TEST_CASE("range sensors with every error on give the same bits on every platform") {
  const World world = sensor_yard();
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  const RayCaster caster(world, &shell);
  FaultConfig faults;
  faults.drop = 0.1;
  LidarConfig rows = make_rows_64(7);
  rows.columns = 60;
  rows.noise = every_error();
  RollingLaserConfig rolling;
  rolling.beams = 91;
  rolling.lines_per_scan = 2;
  rolling.noise = every_error();
  SslConfig solid;
  solid.enabled = true;
  solid.noise = every_error();
  LidarModel lidar(rows, faults, 21, 0);
  RollingLaser laser(rolling, faults, 22, 0);
  SslSensor ssl(solid, faults, 23, 0);
  drivers::SslStub link;
  oracle::KeepingSink lidar_sink;
  oracle::KeepingSink laser_sink;
  RangeDigest answers;
  rt::SslReturns returns;
  for (int ms = 0; ms < 400; ++ms) {
    if (ms % 20 == 0) {
      rt::SslCommand command;
      command.number = static_cast<std::uint32_t>(ms);
      command.rays = 100;
      for (std::uint32_t i = 0; i < 100; ++i)
        command.direction[i] =
            static_cast<std::uint16_t>((i * 191 + static_cast<std::uint32_t>(ms) * 7) % rt::kSslDirections);
      REQUIRE(link.send(command) == Status::ok);
    }
    const SensorStep step = portable_step(ms);
    lidar.advance(caster, step, lidar_sink);
    laser.advance(caster, step, laser_sink);
    ssl.advance(caster, step, link);
    if (link.receive(returns) != Status::ok) continue;
    answers.add(static_cast<std::uint64_t>(returns.stamp_ns));
    for (std::uint32_t i = 0; i < returns.rays; ++i) answers.add(returns.range_mm[i]);
  }
  RangeDigest points[2];
  points[0].add(lidar_sink);
  points[1].add(laser_sink);
  CHECK(lidar.ranges().mixed > 100);
  CHECK(lidar.ranges().weak > 100);
  CHECK(laser.ranges().own > 20);
  CHECK(points[0].value == 0x82259aa1b37e05edu);
  CHECK(points[1].value == 0x6e4a96ae25eb7a6bu);
  CHECK(answers.value == 0xb3268079800eafa4u);
}

}  // namespace sortie::hil
