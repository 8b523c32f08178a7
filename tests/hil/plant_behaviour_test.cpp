// SPDX-License-Identifier: BSD-3-Clause
// What the reference simulator's integration tests assert of its tracked vehicle, with their tolerances, at 1
// ms; and standing on stairs, penetration, and the digest of a fixed drive.
#include "plant_bench.hpp"
#include "plant_digest.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

/// Twist command as the reference's tests give it: at once.
void twist(PlantBench& bench, double forward_m_s, double turn_rad_s, double seconds) {
  const double half = turn_rad_s * 0.1985;
  for (long i = std::lround(seconds / bench.dt_s); i > 0; --i)
    bench.step(forward_m_s - half, forward_m_s + half);
}

}  // namespace

TEST_CASE("plant: rest, straight, rotation and circle as in the reference simulator", "[plant]") {
  PlantBench bench;
  twist(bench, 0, 0, 1);
  CHECK(std::fabs(bench.position().x) < 0.1);
  CHECK(std::fabs(bench.position().z - 0.0719) < 0.01);
  CHECK(std::fabs(bench.pitch()) < 0.01);
  twist(bench, 1, 0, 1);
  CHECK(bench.position().x == Approx(1.0).margin(0.1));
  CHECK(std::fabs(bench.position().y) < 0.1);
  CHECK(std::fabs(bench.position().z - 0.0719) < 0.01);
  CHECK(std::fabs(bench.yaw_rad) < 0.1);
  twist(bench, 0, 0, 1);
  twist(bench, 0, 0.25, 1);
  CHECK(bench.yaw_rad == Approx(0.25).margin(0.1));
  PlantBench circle;
  twist(circle, 0.5, 0.2, 1);
  CHECK(circle.position().x == Approx(0.4).margin(0.1));
  CHECK(circle.position().y == Approx(0.15).margin(0.11));
  CHECK(circle.yaw_rad == Approx(0.2).margin(0.1));
}

TEST_CASE("plant: stairs of 7.5 cm as in the reference simulator", "[plant]") {
  PlantBench bench({}, 1e-3, [](PlantScene& scene) {
    PlantBench::on_plane(scene);
    REQUIRE(add_stairs(scene, {{0.8, 0, 0}, 0}, {20, 0.175, 0.075, 1.0, 2.0}) == Status::ok);
  });
  twist(bench, 1, 0, 3.5);
  CHECK(bench.position().x == Approx(3.4).margin(0.35));
  CHECK(bench.position().z > 0.6);
  CHECK(bench.pitch() == Approx(-0.4).margin(0.1));
  CHECK(std::fabs(bench.yaw_rad) < 0.1);
}

TEST_CASE("plant: over a cylinder backwards, over a box on its flippers and back", "[plant]") {
  PlantBench cylinder({}, 1e-3, [](PlantScene& scene) {
    PlantBench::on_plane(scene);
    REQUIRE(scene.add_cylinder({-0.8, 0, -0.06}, {}, 0.15, 0.4) == Status::ok);
  });
  twist(cylinder, -1, 0, 2);
  CHECK(cylinder.position().x < -0.99);
  CHECK(std::fabs(cylinder.position().y) < 0.5);

  PlantConfig config;
  config.start_m = {0.5, 2,
                    0.07192};  // the published assertions name no start; the box costs 0.7 m of travel
  config.start_q_world_body = from_yaw_pitch_roll(3.14159265358979, 0, 0);
  PlantBench box(config, 1e-3, [](PlantScene& scene) {
    PlantBench::on_plane(scene);
    REQUIRE(scene.add_box({2, 2, 0.028}, from_yaw_pitch_roll(1.5707963, 0, 1.7821), {0.425, 0.075, 0.25}) ==
            Status::ok);
  });
  twist(box, -1, 0, 4);
  CHECK(box.position().x > 3.5);
  CHECK(std::fabs(box.position().y - 2) < 0.1);
  twist(box, 1, 0, 4);
  CHECK(box.position().x < 1.0);
}

TEST_CASE("plant: without surface motion the belts move nothing", "[plant]") {
  PlantConfig config;
  config.vehicle.mode = ContactMode::still;
  PlantBench bench(config);
  twist(bench, 1, 0, 0.5);
  CHECK(std::fabs(bench.position().x) < 1e-6);
  CHECK(bench.plant->state().left_m == Approx(0.5));
}

TEST_CASE("plant: stands on stairs without creeping", "[plant][heavy]") {
  const double dt = GENERATE(1e-3, 2e-3, 5e-3, 1e-2);
  CAPTURE(dt);
  PlantConfig config;
  config.vehicle.friction = 1.0;
  for (int f = 2; f < kFlippers; ++f) config.start_flipper_rad[f] = -0.1;
  PlantBench bench(config, dt, [](PlantScene& scene) {
    PlantBench::on_plane(scene);
    REQUIRE(add_stairs(scene, {{0.8, 0, 0}, 0}, {}) == Status::ok);
  });
  bench.drive(0.3, 0.3, 5, 1.0);
  bench.drive(0, 0, 2, 1.0);
  const Vec3 before = bench.position();
  const double pitch = bench.pitch();
  bench.drive(0, 0, 10, 1.0);
  CHECK(norm(bench.position() - before) < 1e-4);
  CHECK(std::fabs(bench.pitch() - pitch) < 1e-4);
  CHECK(bench.plant->counters().penetration_m < (dt < 2e-3 ? 1e-3 : 3e-3));
}

TEST_CASE("plant: a fixed drive has the digest that was committed", "[plant]") {
  CHECK(drive_digest(false) == 0x1f6d67dd0a5bb64du);
  CHECK(drive_digest(true) == 0x4beaf4fe8aa9b9eeu);
}
