// SPDX-License-Identifier: BSD-3-Clause
// A lidar of 64 rows: rays where closed forms and per-ray poses put them.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>

#include "hil/lidar_model.hpp"
#include "tests/hil/exact_ranges.hpp"

namespace sortie::hil {
namespace {

LidarConfig exact_rows_64(std::uint32_t columns) {
  LidarConfig config = make_rows_64(3);
  config.columns = columns;
  config.noise = exact_ranges();
  config.keep_truth = true;
  tilt_mount(config);
  return config;
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

}  // namespace sortie::hil
