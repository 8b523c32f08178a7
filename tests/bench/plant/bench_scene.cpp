// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/plant/bench_scene.hpp"

#include <cmath>

#include "hil/plant/obstacles.hpp"

namespace sortie::bench {

namespace {

using hil::PlantScene;
using hil::Quat;
using hil::Vec3;

constexpr double kPi = 3.14159265358979323846;
constexpr double kHeight = 0.07192;             // of the vehicle's origin above what it stands on
constexpr double kSlope = 20.0 * kPi / 180.0;   // of the ramp
constexpr double kOnRamp = 1.0;                 // along the slope, where that drive begins
const double kFlight = std::atan2(0.17, 0.28);  // slope over the noses of the stairs

// A scene is set-up code over few solids, which always fit.
void must(Status) {}

void plane(PlantScene& scene) { must(scene.add_half_space({0, 0, 1}, {0, 0, 0})); }

void ramp(PlantScene& scene) {
  plane(scene);
  must(hil::add_ramp(scene, {}, kSlope, 6.0, 1.0, 1.5));
}

void stairs_up(PlantScene& scene) {
  plane(scene);
  must(hil::add_stairs(scene, {{0.8, 0, 0}, 0}, {}));
}

// The same flight met from above: its top edge lies at x = 0, its foot at x = 4 * 0.28.
void stairs_down(PlantScene& scene) {
  plane(scene);
  must(hil::add_stairs(scene, {{4 * 0.28, 0, 0}, kPi}, {}));
}

void pallet(PlantScene& scene) {
  plane(scene);
  must(hil::add_pallet(scene, {{0.8, 0, 0}, 0}));
}

// On a slope that goes up along x, `along_m` from the point where it begins at (x_m, z_m).
BenchPose on_slope(double x_m, double z_m, double slope_rad, double along_m) {
  const Quat q = hil::from_yaw_pitch_roll(0, -slope_rad, 0);
  return {Vec3{x_m, 0, z_m} + hil::rotate(q, {along_m, 0, kHeight}), q};
}

BenchPose level(double x_m, double z_m) { return {{x_m, 0, z_m + kHeight}, {}}; }

std::vector<BenchScene> make() {
  std::vector<BenchScene> scenes;
  const auto add = [&scenes](const BenchScene& scene) { scenes.push_back(scene); };
  add({"straight",
       "0.3 m/s on a plane",
       10,
       0,
       0.7,
       plane,
       level(0, 0),
       {0.5, 0.5, 0.5, 0.5},
       {{0.3, 0}},
       true,
       {"end d_t", 0.1, -1}});
  add({"rotate",
       "0.6 rad/s on the spot",
       10,
       0,
       0.7,
       plane,
       level(0, 0),
       {0.5, 0.5, 0.5, 0.5},
       {{0, 0.6}},
       true,
       {"end d_w", -1, 0.1}});
  add({"circular",
       "0.2 m/s and 0.25 rad/s, once around",
       26,
       0,
       0.7,
       plane,
       level(0, 0),
       {0.5, 0.5, 0.5, 0.5},
       {{0.2, 0.25}},
       true,
       {"sum d_t", 157.8, -1}});
  add({"ramp",
       "0.3 m/s up a ramp of 20 degrees",
       10,
       0,
       0.7,
       ramp,
       on_slope(0, 0, kSlope, kOnRamp),
       {0.5, 0.5, 0.5, 0.5},
       {{0.3, 0}},
       true,
       {"sums", 8.0, 1.8}});
  add({"stairs-down",
       "0.3 m/s from a landing down five steps of 0.28 / 0.17 m",
       10,
       0,
       1.0,
       stairs_down,
       level(-0.9, 5 * 0.17),
       {0.3, 0.3, 0.1, 0.1},
       {{0.3, 0}},
       false,
       {"sums", 12.1, 14.0}});
  // Two noses below the straight run, the centre of mass between them: 0.24 m ahead of the second step's
  // nose.
  add({"stand",
       "at rest on the stairs",
       10,
       1,
       1.0,
       stairs_up,
       on_slope(0.8 + 0.28, 2 * 0.17, kFlight, 0.24),
       {0.5, 0.5, 0.2, 0.2},
       {},
       true,
       {"sums", 0.0, 0.0}});
  add({"pallet",
       "0.2 m/s over a pallet",
       16,
       0,
       0.7,
       pallet,
       level(0, 0),
       {0.7, 0.7, 0.15, 0.15},
       {{0.2, 0}},
       false,
       {"sums", 49.9, 27.6}});
  add({"back-and-forth",
       "three times 0.3 m/s to and fro",
       16,
       0,
       0.7,
       plane,
       level(0, 0),
       {0.5, 0.5, 0.5, 0.5},
       {{0.3, 0, 0, 2},
        {-0.3, 0, 2.5, 4.5},
        {0.3, 0, 5, 7},
        {-0.3, 0, 7.5, 9.5},
        {0.3, 0, 10, 12},
        {-0.3, 0, 12.5, 14.5}},
       true,
       {"end d_t", 0.0, -1}});
  add({"stairs-up",
       "0.3 m/s up five steps of 0.28 / 0.17 m",
       10,
       0,
       1.2,
       stairs_up,
       level(0, 0),
       {0.7, 0.7, 0.0, 0.0},
       {{0.3, 0}},
       false,
       {}});
  return scenes;
}

}  // namespace

const std::vector<BenchScene>& bench_scenes() {
  static const std::vector<BenchScene> scenes = make();
  return scenes;
}

}  // namespace sortie::bench
