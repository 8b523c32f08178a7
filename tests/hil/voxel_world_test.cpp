// SPDX-License-Identifier: BSD-3-Clause
// A recorded place as a world: its caster beside one that asks every cell.
#include "hil/voxel_world.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "hil/ray_caster.hpp"
#include "hil/ssl_sensor.hpp"

namespace {

using sortie::Status;
using namespace sortie::hil;

constexpr std::int32_t kPlaceSize[3] = {13, 9, 7};
constexpr double kPlaceVoxel_m = 0.2;
const Vec3 kPlaceLow_m{-1.0, 0.4, -0.6};

struct Place {
  std::vector<std::uint32_t> bits =
      std::vector<std::uint32_t>(static_cast<std::size_t>(VoxelWorld::words(kPlaceSize)));
  VoxelWorld world{kPlaceVoxel_m, kPlaceLow_m, kPlaceSize, bits};
};

// Way in and out of a cell, in metres; false when it is missed.
bool crosses(const Vec3& from, const Vec3& way, const std::int32_t (&cell)[3], double& in, double& out) {
  const double p[3] = {from.x, from.y, from.z};
  const double d[3] = {way.x, way.y, way.z};
  const double low[3] = {kPlaceLow_m.x, kPlaceLow_m.y, kPlaceLow_m.z};
  in = 0;
  out = 1e9;
  for (int a = 0; a < 3; ++a) {
    const double first = low[a] + kPlaceVoxel_m * cell[a];
    const double last = first + kPlaceVoxel_m;
    if (d[a] == 0.0) {
      if (p[a] < first || p[a] >= last) return false;
      continue;
    }
    in = std::max(in, ((d[a] > 0 ? first : last) - p[a]) / d[a]);
    out = std::min(out, ((d[a] > 0 ? last : first) - p[a]) / d[a]);
  }
  return in < out;
}

}  // namespace

TEST_CASE(
    "A ray meets the cell of a recorded place that is nearest of all, from inside and outside the box") {
  Place place;
  std::mt19937_64 random(21);
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 60; ++i)
    (void)place.world.add({uniform(-1, 1.6), uniform(0.4, 2.2), uniform(-0.6, 0.8)});
  REQUIRE(place.world.solids() > 40);
  int hits = 0;
  for (int ray = 0; ray < 4000; ++ray) {
    const Vec3 from{uniform(-3, 3.6), uniform(-1.6, 4.2), uniform(-2, 2)};
    Vec3 way{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    if (ray % 2 == 1) way = Vec3{uniform(-1, 1.6), uniform(0.4, 2.2), uniform(-0.6, 0.8)} - from;
    if (ray % 5 == 0) way.x = 0;
    if (ray % 10 == 0) way.y = 0;
    way = (1.0 / norm(way)) * way;
    const double most = ray % 3 == 0 ? 1.5 : 20.0;
    double nearest = most;
    bool near_corner = false;
    std::int32_t cell[3];
    for (cell[2] = 0; cell[2] < kPlaceSize[2]; ++cell[2])
      for (cell[1] = 0; cell[1] < kPlaceSize[1]; ++cell[1])
        for (cell[0] = 0; cell[0] < kPlaceSize[0]; ++cell[0]) {
          double in{};
          double out{};
          if (!place.world.solid(cell[0], cell[1], cell[2]) || !crosses(from, way, cell, in, out)) continue;
          near_corner = near_corner || out - in < 1e-9;
          nearest = std::min(nearest, in > 0 ? 0.5 * (in + out) : 0.0);
        }
    if (near_corner) continue;
    const Hit hit = place.world.cast(from, way, most);
    CAPTURE(ray, from.x, from.y, from.z, way.x, way.y, way.z);
    REQUIRE(hit.range_m == Approx(nearest).margin(1e-9));
    REQUIRE(static_cast<bool>(hit) == (nearest < most));
    if (hit && hit.range_m > 0) REQUIRE(dot(hit.normal, way) < 0);
    hits += hit ? 1 : 0;
  }
  CHECK(hits > 500);
}

TEST_CASE("A place refuses what is no cell of it, and settings that cannot be") {
  Place place;
  const double nan = std::nan("");
  CHECK(place.world.add({-0.99, 0.41, -0.59}) == Status::ok);
  CHECK(place.world.add({-0.99, 0.41, -0.59}) == Status::ok);
  CHECK(place.world.solids() == 1);
  CHECK(place.world.add({-1.01, 0.41, -0.59}) == Status::out_of_range);
  CHECK(place.world.add({1.61, 0.41, -0.59}) == Status::out_of_range);
  CHECK(place.world.add({nan, 0.41, -0.59}) == Status::out_of_range);
  CHECK_FALSE(place.world.cast({nan, 0, 0}, {1, 0, 0}, 5));
  CHECK_FALSE(VoxelWorld(0.0, kPlaceLow_m, kPlaceSize, place.bits).usable());
  CHECK_FALSE(VoxelWorld(0.2, kPlaceLow_m, kPlaceSize, std::span(place.bits).first(3)).usable());
  const std::int32_t flat[3] = {4, 0, 4};
  const VoxelWorld none(0.2, kPlaceLow_m, flat, place.bits);
  CHECK_FALSE(none.usable());
  CHECK_FALSE(none.cast({0, 0, 0}, {1, 0, 0}, 5));
}

TEST_CASE("A solid-state lidar looks at a recorded place as at a built one") {
  Place place;
  for (double y = 0.5; y < 2.2; y += 0.2)
    for (double z = -0.5; z < 0.8; z += 0.2) REQUIRE(place.world.add({1.1, y, z}) == Status::ok);
  SslConfig config;
  config.enabled = true;
  config.noise.sigma_m = 0;
  config.noise.loss = 0;
  config.mount_m[0] = config.mount_m[2] = 0;
  SslSensor sensor(config, {}, 1, 0);
  sortie::drivers::SslStub link;
  sortie::rt::SslCommand command;
  command.number = 7;
  command.rays = 1;
  command.direction[0] = 60 * 160 + 80;  // nearly straight on
  REQUIRE(link.send(command) == Status::ok);
  SensorStep step;
  step.before.q_world_body = step.after.q_world_body = {1, 0, 0, 0};
  step.before.p_world_body_m = step.after.p_world_body_m = {-0.5, 1.3, 0.1};
  step.after.stamp_ns = 100'000'000;
  sensor.advance(RayCaster(place.world), step, link);
  sortie::rt::SslReturns returns;
  REQUIRE(link.receive(returns) == Status::ok);
  // The wall's cells reach from x = 1.0 to 1.2.
  const double way = sortie::rt::ssl_direction(command.direction[0]).x;
  CHECK(0.001 * returns.range_mm[0] == Approx(1.6 / way).margin(0.0006));
}
