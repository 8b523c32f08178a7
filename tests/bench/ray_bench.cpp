// SPDX-License-Identifier: BSD-3-Clause
// The simulator's ray caster against asking every solid, on rays of a lidar through furnished scenes; ns per
// ray. The robot's own outline is asked for beside it.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "hil/ray_caster.hpp"

namespace {

using namespace sortie;
using namespace sortie::hil;

constexpr std::size_t kRays = 1024;
constexpr double kMaxRange_m = 48.0;

// A hall of 20 x 14 m with four walls, and `solids` boxes, tilted boxes and cylinders in it.
struct RayScene {
  explicit RayScene(int solids) {
    std::mt19937 random(11);
    const auto draw = [&random](double low, double high) {
      return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
    };
    ok = world.add(make_box({10, 0, 0, 0.2, 14, 0, 3})) == Status::ok;
    ok = ok && world.add(make_box({-10, 0, 0, 0.2, 14, 0, 3})) == Status::ok;
    ok = ok && world.add(make_box({0, 7, 0, 20, 0.2, 0, 3})) == Status::ok;
    ok = ok && world.add(make_box({0, -7, 0, 20, 0.2, 0, 3})) == Status::ok;
    for (int i = 4; i < solids && ok; ++i) {
      const double x = draw(-9.5, 9.5);
      const double y = draw(1.0, 6.5) * (i % 2 == 0 ? 1.0 : -1.0);
      const double size = draw(0.1, 0.4);
      const double turn = draw(-1.5, 1.5);
      if (i % 3 == 0) {
        ok = world.add(make_tilted_box({x, y, size}, axes_of(from_yaw_pitch_roll(turn, 0.3, 0.2)),
                                       {size, 0.5 * size, size})) == Status::ok;
      } else if (i % 3 == 1) {
        ok = world.add(make_box({x, y, turn, 2 * size, size, 0, 3 * size})) == Status::ok;
      } else {
        ok = world.add(make_cylinder(x, y, size, 0, 4 * size)) == Status::ok;
      }
    }
    ok = ok && world.finalize() == Status::ok;
    for (std::size_t i = 0; i < kRays; ++i) {
      const double azimuth = draw(-3.14, 3.14);
      const double up = draw(-0.6, 0.3);
      rays.push_back({std::cos(up) * std::cos(azimuth), std::cos(up) * std::sin(azimuth), std::sin(up)});
      BodyInstant body;
      body.p_world_body_m = {draw(-9.0, 9.0), draw(-0.5, 0.5), 0.0};
      body.q_world_body = from_yaw_pitch_roll(draw(-3.0, 3.0), 0.02, 0.01);
      for (double& angle : body.flipper_rad) angle = draw(-0.5, 1.0);
      aims.emplace_back();
      ok = ok && RayCaster(world, &shell).aim({{0.05, 0, 0.45}, {}}, body, aims.back()) == Status::ok;
    }
  }
  bool ok{};
  World world;
  VehicleShell shell{VehicleConfig{}, 0.07192};
  std::vector<Vec3> rays;
  std::vector<RayCaster::Aim> aims;
};

const RayScene& ray_scene(int solids) {
  static const auto few = std::make_unique<RayScene>(44);
  static const auto many = std::make_unique<RayScene>(static_cast<int>(World::kMaxSolids));
  return solids == 44 ? *few : *many;
}

template <class Cast>
void run_rays(benchmark::State& state, const RayScene& scene, Cast cast) {
  if (!scene.ok) state.SkipWithError("the scene was refused");
  for (auto _ : state) {
    double sum = 0.0;
    for (std::size_t i = 0; i < kRays; ++i) sum += cast(scene.aims[i], scene.rays[i]).range_m;
    benchmark::DoNotOptimize(sum);
  }
  state.counters["ops"] = static_cast<double>(kRays);
}

void quick(benchmark::State& state, int solids, bool robot) {
  const RayScene& scene = ray_scene(solids);
  const RayCaster caster(scene.world, robot ? &scene.shell : nullptr);
  run_rays(state, scene,
           [&](const RayCaster::Aim& aim, const Vec3& ray) { return caster.cast(aim, ray, kMaxRange_m); });
}

void brute(benchmark::State& state, int solids, bool robot) {
  const RayScene& scene = ray_scene(solids);
  const RayCaster caster(scene.world, robot ? &scene.shell : nullptr);
  run_rays(state, scene, [&](const RayCaster::Aim& aim, const Vec3& ray) {
    return caster.cast_brute_force(aim, ray, kMaxRange_m);
  });
}

BENCHMARK_CAPTURE(quick, hall, 44, false)->Name("ray: 44 solids/sortie");
BENCHMARK_CAPTURE(brute, hall, 44, false)->Name("ray: 44 solids/every solid");
BENCHMARK_CAPTURE(quick, robot, 44, true)->Name("ray: 44 solids and the robot/sortie");
BENCHMARK_CAPTURE(brute, robot, 44, true)->Name("ray: 44 solids and the robot/every solid and part");
BENCHMARK_CAPTURE(quick, full, 256, true)->Name("ray: 256 solids and the robot/sortie");
BENCHMARK_CAPTURE(brute, full, 256, true)->Name("ray: 256 solids and the robot/every solid and part");

}  // namespace
