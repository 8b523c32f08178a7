// SPDX-License-Identifier: BSD-3-Clause
// Whole drives judged by others: the dense solver, the mirror image, a step five times shorter. The long
// tests have all drives in both contact modes.
#include "plant_proofs.hpp"

using namespace sortie;
using namespace sortie::hil;

TEST_CASE("plant: drives end where the dense solver's end", "[plant][heavy]") {
  const std::vector<ProvingDrive> drives = proving_drives();
  const auto drive = GENERATE(2u, 4u);  // beam, stairs up
  CAPTURE(drives[drive].name);
  const DenseProof proof = prove_against_dense(drives[drive], {5e-3, ContactMode::csm});
  CHECK(proof.ends_apart_m <= 1e-3);
  check(proof);
}

TEST_CASE("plant: a mirrored scene gives the mirrored path on obstacles too", "[plant][heavy]") {
  const ProvingWay way{5e-3, ContactMode::csm};
  int judged = 0;
  for (const ProvingDrive& drive : proving_drives()) {
    if (is_marginal(drive, way)) continue;
    prove_mirror_image(drive, way);
    ++judged;
  }
  CHECK(judged >= 5);
}

TEST_CASE("plant: drives at 5 ms end within 2 cm of those at 1 ms", "[plant][heavy]") {
  int judged = 0;
  for (const ProvingDrive& drive : proving_drives()) {
    CAPTURE(drive.name);
    CHECK(prove_step_size(drive, {}) < 0.02);
    ++judged;
  }
  CHECK(judged >= 6);
}

TEST_CASE("plant: on flat ground each belt has eight contacts and more, all loaded", "[plant]") {
  PlantConfig config;
  config.vehicle.mode = ContactMode::belt;
  PlantBench bench(config);
  bench.drive(0.2, 0.3, 1.0, 1.0);
  int loaded[kParts]{};
  for (std::uint32_t i = 0; i < bench.plant->contacts().size(); ++i) {
    const ContactPoint& c = bench.plant->contacts()[i];
    if (dot(c.normal, c.impulse_ns) > 0.0) ++loaded[bench.plant->tags()[i].part];
  }
  CHECK(loaded[1] >= 8);
  CHECK(loaded[2] >= 8);
}

TEST_CASE("plant: one track alone on a beam drives forward, and turns away from it", "[plant]") {
  const auto mode = GENERATE(ContactMode::csm, ContactMode::belt);
  const double side = GENERATE(1.0, -1.0);
  CAPTURE(static_cast<int>(mode), side);
  PlantConfig config;
  config.vehicle.mode = mode;
  for (double& angle : config.start_flipper_rad) angle = 1.2;
  PlantBench bench(config, 1e-3, [side](PlantScene& scene) {
    REQUIRE(scene.add_box({0, side * 0.1985, -0.1}, {}, {3.0, 0.04, 0.1}) == Status::ok);
  });
  // It tips to the other side at once: what counts is the time before it has left the beam.
  for (int i = 0; i < 60; ++i) {
    bench.step(0.5, 0.5);
    REQUIRE(bench.plant->contacts().size() > 0);
    for (const ContactTag& tag : bench.plant->tags()) REQUIRE(side_of(tag.part) == static_cast<int>(side));
    REQUIRE(bench.plant->report().solver.converged);
  }
  const Generalised& u = bench.plant->state().velocity;
  CHECK(u.linear.x > 0.1);
  CHECK(u.linear.x < 0.5);
  CHECK(side * u.angular.x > 0.0);  // over the edge
  CHECK(side * u.angular.z < 0.0);  // the push is on one side of the mass
  CHECK(bench.plant->counters().rejected == 0);
}

TEST_CASE("plant: lying on the side of a track, belts move nothing", "[plant]") {
  const auto mode = GENERATE(ContactMode::csm, ContactMode::belt);
  const double side = GENERATE(1.0, -1.0);
  CAPTURE(static_cast<int>(mode), side);
  PlantConfig config;
  config.vehicle.mode = mode;
  for (double& angle : config.start_flipper_rad) angle = 0.0;
  config.start_q_world_body = from_yaw_pitch_roll(0, 0, side * 1.57079632679489662);
  config.start_m = {0, 0, 0.2985};
  PlantBench bench(config);
  bench.drive(0, 0, 1, 1);
  const Vec3 rest = bench.position();
  CHECK(bench.plant->contacts().size() > 0);
  for (const ContactPoint& c : bench.plant->contacts()) CHECK(c.normal.y == Approx(side).margin(1e-3));
  bench.drive(0.5, 0.5, 2, 1);
  bench.drive(-0.5, 0.5, 2, 1);
  CHECK(norm(bench.position() - rest) < 1e-3);
  CHECK(bench.plant->state().left_m == Approx(0.5 * (2 - 0.25) - 0.5 * (2 - 0.25)).margin(1e-9));
}

TEST_CASE("plant: a contact under the turning centre holds while the others go round it", "[plant]") {
  PlantConfig config;
  // The turning centre lies where the right track's left edge begins: a contact of its own at zero speed.
  config.vehicle.icr_x_m = -0.25;
  PlantBench bench(config);
  const double edge = -0.1985 + 0.5 * config.vehicle.track_width_m;
  bench.drive(0, 0, 0.2, 1);
  const double turn = 0.4;
  const double forward = turn * edge;  // v / w is the centre's y
  bench.drive(forward - turn * 0.1985, forward + turn * 0.1985, 2.0, 1.0);
  const double speed = bench.plant->state().velocity.angular.z;
  CHECK(speed == Approx(turn).epsilon(1e-4));
  double least = 1.0;
  for (const ContactPoint& c : bench.plant->contacts()) {
    const Vec3 arm = c.point_m - Vec3{-0.25, edge, c.point_m.z};
    least = std::min(least, norm(arm));
    CHECK(norm(c.target_m_s) == Approx(turn * norm(arm)).margin(1e-4));
  }
  CHECK(least < 1e-3);
  const Vec3 fixed{-0.25, edge, -0.07192};
  CHECK(norm(bench.plant->velocity_world_m_s(fixed)) < 1e-3);
}
