// SPDX-License-Identifier: BSD-3-Clause
// The hall: repeatable by seed, free where the robot drives, open where the doors are.
#include "hil/hall.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "oracle.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {
std::unique_ptr<World> hall(const HallConfig& config, HallReport* report = nullptr) {
  auto world = std::make_unique<World>();
  const HallReport built = build_hall(config, *world);
  if (report != nullptr) *report = built;
  return world;
}
}  // namespace

TEST_CASE("a seed gives one hall, another seed another") {
  HallConfig config;
  config.seed = 7;
  HallReport report;
  const auto a = hall(config, &report);
  const auto b = hall(config);
  config.seed = 8;
  const auto c = hall(config);
  CHECK(report.seed == 7);
  CHECK(report.furniture_placed > 20);
  CHECK(report.furniture_placed + report.furniture_left_out == config.furniture);
  REQUIRE(a->size() == b->size());
  bool differs = a->size() != c->size();
  for (std::size_t i = 0; i < a->size(); ++i) {
    CHECK(a->solid(i).center_x_m == b->solid(i).center_x_m);
    CHECK(a->solid(i).sin_yaw == b->solid(i).sin_yaw);
    CHECK(a->solid(i).top_m == b->solid(i).top_m);
    differs = differs || a->solid(i).center_x_m != c->solid(i).center_x_m;
  }
  CHECK(differs);
}

TEST_CASE("the robot's way through the hall is free for every seed", "[heavy]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    HallConfig config;
    config.seed = seed;
    const auto world = hall(config);
    for (std::uint32_t i = 0; i + 1 < config.path_points; ++i) {
      const PlanPoint a = config.path_m[i];
      const PlanPoint b = config.path_m[i + 1];
      const double length = std::sqrt((b.x_m - a.x_m) * (b.x_m - a.x_m) + (b.y_m - a.y_m) * (b.y_m - a.y_m));
      for (double t = 0.0; t <= length; t += 0.05) {
        const double x = a.x_m + (b.x_m - a.x_m) * t / length;
        const double y = a.y_m + (b.y_m - a.y_m) * t / length;
        const double ground = world->terrain_height(x, y);
        for (double angle = 0.0; angle < 6.28; angle += 0.7) {
          const Vec3 p{x + 0.45 * std::cos(angle), y + 0.45 * std::sin(angle), ground + 0.2};
          if (world->terrain_height(p.x, p.y) != ground) continue;  // beside or on the ramp
          REQUIRE(oracle::world_depth(*world, p) > 0.0);
        }
      }
    }
  }
}

TEST_CASE("walls have the asked size, and openings where doors are") {
  HallConfig config;
  config.furniture = 0;
  const auto world = hall(config);
  CHECK(world->cast({0, 0, 2.9}, {-1, 0, 0}, 50).range_m == Approx(3.0));
  CHECK(world->cast({0, 3, 0.5}, {0, 1, 0}, 50).range_m == Approx(4.0));
  CHECK(world->cast({12, 0, 0.5}, {1, 0, 0}, 50).range_m == Approx(5.0));
  CHECK_FALSE(world->cast({7, 3, 1.0}, {0, 1, 0}, 50));                   // through the door
  CHECK(world->cast({7, 3, 2.5}, {0, 1, 0}, 50).range_m == Approx(4.0));  // the wall above it
  CHECK(world->cast({9, 4, 1.0}, {1, 0, 0}, 50).range_m == Approx(8.0));  // through the partition's door
  CHECK(world->cast({9, 0, 1.0}, {1, 0, 0}, 50).range_m == Approx(1.9));  // the partition
  CHECK(world->terrain_height(5, 0) == Approx(config.ramp_height_m));
  CHECK(world->terrain_height(5 - 0.6 - 0.75, 0) == Approx(0.5 * config.ramp_height_m));
  CHECK(world->terrain_height(5 + 0.6 + 0.75, 0) == Approx(0.5 * config.ramp_height_m));
}

TEST_CASE("the distance to the free path is that of the nearest segment") {
  HallConfig config;
  config.path_m[0] = {0, 0};
  config.path_m[1] = {4, 0};
  config.path_m[2] = {4, 3};
  config.path_points = 3;
  CHECK(distance_to_path(config, 2, 1.5) == Approx(1.5));
  CHECK(distance_to_path(config, 5, 5) == Approx(std::sqrt(5.0)));
  CHECK(distance_to_path(config, -3, -4) == Approx(5.0));
  CHECK(distance_to_path(config, 4.5, 1) == Approx(0.5));
  config.path_points = 0;
  CHECK(std::isinf(distance_to_path(config, 0, 0)));
}

TEST_CASE("a hall that cannot be built says which setting to change") {
  World world;
  HallConfig config;
  config.door_width_m = 30.0;
  CHECK_THROWS_WITH(build_hall(config, world), Catch::Contains("door_width_m"));
  World second;
  config = {};
  config.path_points = 99;
  CHECK_THROWS_WITH(build_hall(config, second), Catch::Contains("limit is 16"));
  World third;
  config = {};
  config.wall_m = 0.0;
  CHECK_THROWS_WITH(build_hall(config, third), Catch::Contains("wall"));
}
