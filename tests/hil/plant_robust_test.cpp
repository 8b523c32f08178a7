// SPDX-License-Identifier: BSD-3-Clause
// What the tracked plant must never do: gain energy with still belts, become NaN, prefer a side, take the
// heap.
#include "hil/random.hpp"
#include "plant_bench.hpp"
#include "plant_trials.hpp"
#include "rt/posix/heap_trap.hpp"

using namespace sortie;
using namespace sortie::hil;

TEST_CASE("plant: dropped at random, it never gains energy", "[plant]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    CHECK(gain_of_drop(seed) <= 1e-9);
  }
}

TEST_CASE("plant: stays finite under random extremes", "[plant][heavy]") {
  constexpr std::uint64_t kSeed = 7;
  CAPTURE(kSeed);
  const Shaken shaken = shake(kSeed, 10'000);
  CHECK(shaken.first_not_finite == -1);
  CHECK(shaken.wrong == 0);
  CHECK(shaken.rejected <= 10);
}

TEST_CASE("plant: mirrored scene and commands give the mirrored path", "[plant]") {
  const auto mode = GENERATE(ContactMode::csm, ContactMode::belt);
  const double slope = GENERATE(0.0, 0.3);
  CAPTURE(static_cast<int>(mode), slope);
  PlantConfig config;
  config.vehicle.mode = mode;
  const auto build = [slope](PlantScene& scene) {
    REQUIRE(scene.add_half_space({-std::sin(slope), 0, std::cos(slope)}, {0, 0, 0}) == Status::ok);
  };
  config.start_q_world_body = from_yaw_pitch_roll(0, -slope, 0);
  config.start_m = rotate(config.start_q_world_body, {0, 0, 0.0720});
  PlantBench a(config, 2e-3, build);
  PlantBench b(config, 2e-3, build);
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double fast = 0.3 * std::min(1.0, i / 300.0);
    const double slow = (i / 500 % 2 == 0 ? 0.1 : -0.1) * std::min(1.0, i / 300.0);
    a.step(fast, slow);
    b.step(slow, fast);
    const Vec3 p = a.position();
    const Vec3 q = b.position();
    worst = std::max(worst, norm(p - Vec3{q.x, -q.y, q.z}));
  }
  INFO("largest difference " << worst);
  CHECK(worst < 1e-9);
}

TEST_CASE("plant: end poses at 5 ms are those at 1 ms", "[plant]") {
  const auto mode = GENERATE(ContactMode::csm, ContactMode::belt);
  const bool pallet = GENERATE(false, true);
  CAPTURE(static_cast<int>(mode), pallet);
  PlantConfig config;
  config.vehicle.mode = mode;
  config.vehicle.friction = 1.0;
  for (int f = 2; f < kFlippers; ++f) config.start_flipper_rad[f] = -0.1;
  const auto build = [pallet](PlantScene& scene) {
    PlantBench::on_plane(scene);
    if (pallet) REQUIRE(add_pallet(scene, {{0.8, 0, 0}, 0}) == Status::ok);
  };
  PlantBench fine(config, 1e-3, build);
  PlantBench coarse(config, 5e-3, build);
  for (PlantBench* bench : {&fine, &coarse}) bench->drive(0.3, pallet ? 0.3 : 0.2, pallet ? 8 : 4, 1.0);
  CHECK(norm(fine.position() - coarse.position()) < 0.02);
  CHECK(fine.plant->counters().penetration_m < 1e-3);
  CHECK(coarse.plant->counters().penetration_m < 3e-3);
}

TEST_CASE("plant: a step takes no heap, refuses nonsense and changes nothing then", "[plant]") {
  PlantBench bench({}, 1e-3, [](PlantScene& scene) {
    PlantBench::on_plane(scene);
    REQUIRE(add_stairs(scene, {{0.5, 0, 0}, 0}, {}) == Status::ok);
  });
  bench.drive(0.3, 0.3, 0.5, 1);
  {
    rt::posix::HeapTrapScope trap;
    for (int i = 0; i < 500; ++i) (void)bench.plant->step(bench.command, 1e-3);
    CHECK(trap.calls() == 0);
  }
  const Vec3 before = bench.position();
  PlantCommand bad = bench.command;
  bad.left_m_s = std::nan("");
  CHECK(bench.plant->step(bad, 1e-3) == Status::not_finite);
  CHECK(bench.plant->step(bench.command, 0.03) == Status::out_of_range);
  CHECK(bench.plant->step(bench.command, 1e-5) == Status::out_of_range);
  CHECK(norm(bench.position() - before) == 0.0);
  PlantConfig config;
  config.vehicle.body_mass_kg = 0.0;
  CHECK_THROWS_WITH((TrackedPlant{config, *bench.scene}), Catch::Contains("masses"));
}

TEST_CASE("plant: the accelerometer at rest reads gravity, in a turn the lever arm's share", "[plant]") {
  PlantBench bench;
  bench.drive(0, 0, 0.1, 1);
  const Vec3 rest = bench.plant->specific_force_m_s2({0.1, 0.05, 0.2});
  CHECK(norm(rest - Vec3{0, 0, 9.81}) < 1e-5);
  bench.drive(-0.2, 0.2, 2, 1);
  const double w = bench.plant->state().velocity.angular.z;
  const Vec3 turning = bench.plant->specific_force_m_s2({0.1, 0, 0});
  CHECK(turning.x == Approx(-w * w * 0.1).margin(2e-3));
  CHECK(turning.z == Approx(9.81).margin(1e-4));
}
