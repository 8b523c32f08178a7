// SPDX-License-Identifier: BSD-3-Clause
// The tracked plant in csm mode against closed forms: straight, on the spot, in circles, back and forth, on
// ramps.
#include "plant_bench.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

constexpr double kG = 9.81;

PlantConfig csm(double mu) {
  PlantConfig config;
  config.vehicle.friction = mu;
  return config;
}

/// A plane that rises along x.
std::function<void(PlantScene&)> slope(double angle_rad) {
  return [angle_rad](PlantScene& scene) {
    REQUIRE(scene.add_half_space({-std::sin(angle_rad), 0, std::cos(angle_rad)}, {0, 0, 0}) == Status::ok);
  };
}

PlantConfig on_slope(double angle_rad, double mu) {
  PlantConfig config = csm(mu);
  config.start_q_world_body = from_yaw_pitch_roll(0, -angle_rad, 0);
  config.start_m = rotate(config.start_q_world_body, {0, 0, 0.07192});
  return config;
}

}  // namespace

TEST_CASE("plant: straight, rotation and circle follow the closed form at every step size", "[plant]") {
  const double dt = GENERATE(1e-3, 2e-3, 5e-3, 1e-2);
  CAPTURE(dt);
  const double mu = 0.7;
  const double ramp = 0.25 * mu * kG;
  {
    PlantBench bench(csm(mu), dt);
    bench.drive(0.3, 0.3, 10, ramp);
    const double expected = 0.3 * PlantBench::ramp_integral(10, 0.3 / ramp);
    CHECK(bench.position().x == Approx(expected).margin(6e-3));
    CHECK(std::fabs(bench.position().y) < 6e-3);
    CHECK(std::fabs(bench.yaw_rad) < 1e-3);
  }
  {
    PlantBench bench(csm(mu), dt);  // 0.6 rad/s
    const double belt = 0.6 * 0.1985;
    bench.drive(-belt, belt, 10, ramp);
    CHECK(bench.yaw_rad == Approx(0.6 * PlantBench::ramp_integral(10, belt / ramp)).margin(5e-3));
    CHECK(norm(bench.position() - Vec3{0, 0, bench.position().z}) < 6e-3);
  }
  {
    PlantBench bench(csm(mu), dt);  // the published 0.2 m/s, 0.25 rad/s
    const double left = 0.2 - 0.25 * 0.1985;
    const double right = 0.2 + 0.25 * 0.1985;
    const double rise = right / ramp;
    double sum = 0.0;
    long count = 0;
    const long every = std::lround(25.0 / dt) / 100;
    bench.drive(left, right, 25, ramp, [&] {
      if (++count % every != 0) return;
      const double turned = 0.25 * PlantBench::ramp_integral(static_cast<double>(count) * dt, rise);
      sum += norm(bench.position() -
                  Vec3{0.8 * std::sin(turned), 0.8 * (1.0 - std::cos(turned)), bench.position().z});
    });
    INFO("summed error " << sum);
    CHECK(sum <= 0.1);
  }
}

TEST_CASE("plant: back and forth ends where it began", "[plant]") {
  const double dt = GENERATE(1e-3, 1e-2);
  CAPTURE(dt);
  PlantBench bench(csm(0.7), dt);
  for (int i = 0; i < 3; ++i) {
    bench.drive(0.3, 0.3, 2, 1.5);
    bench.drive(0, 0, 0.5, 1.5);
    bench.drive(-0.3, -0.3, 2, 1.5);
    bench.drive(0, 0, 0.5, 1.5);
  }
  CHECK(norm(bench.position() - Vec3{0, 0, bench.position().z}) < 1e-2);
}

TEST_CASE("plant: a ramp holds the robot above the friction angle and lets it slide below", "[plant]") {
  const double dt = GENERATE(1e-3, 5e-3, 1e-2);
  CAPTURE(dt);
  const double angle = 0.35;
  {
    PlantBench bench(on_slope(angle, 1.02 * std::tan(angle)), dt, slope(angle));
    bench.drive(0, 0, 0.5, 1);
    const Vec3 before = bench.position();
    bench.drive(0, 0, 5, 1);
    CHECK(norm(bench.position() - before) < 1e-4);
  }
  for (const double share : {0.98, 0.5, 0.0}) {
    CAPTURE(share);
    const double mu = share * std::tan(angle);
    PlantBench bench(on_slope(angle, mu), dt, slope(angle));
    bench.drive(0, 0, 0.2, 1);
    const double before = norm(bench.plant->velocity_world_m_s({}));
    bench.drive(0, 0, 1, 1);
    const double after = norm(bench.plant->velocity_world_m_s({}));
    const double expected = kG * (std::sin(angle) - mu * std::cos(angle));
    CHECK(std::fabs(after - before - expected) < 0.01 * kG * std::sin(angle));
  }
}

TEST_CASE("plant: up a ramp at constant speed ends on the line within 2 mm", "[plant]") {
  const double dt = GENERATE(1e-3, 5e-3);
  const double angle = 0.35;
  PlantBench bench(on_slope(angle, 1.0), dt, slope(angle));
  const Vec3 start = bench.position();
  bench.drive(0.2, 0.2, 5, 1.0);
  const double expected = 0.2 * PlantBench::ramp_integral(5, 0.2);
  CHECK(norm(bench.position() - start - expected * Vec3{std::cos(angle), 0, std::sin(angle)}) < 2e-3);
}

TEST_CASE("plant: belts make turning centres by themselves, and settle", "[plant]") {
  for (const double mu : {0.5, 1.2}) {
    PlantConfig config = csm(mu);
    config.vehicle.mode = ContactMode::belt;
    PlantBench bench(config, 2e-3);
    bench.drive(-0.2, 0.2, 4, 1.0);
    CHECK(bench.plant->contacts().size() >= 16);
    const double rate = bench.plant->state().velocity.angular.z;
    const double efficiency = rate * 2.0 * 0.1985 / 0.4;
    CHECK(efficiency > 0.4);
    CHECK(efficiency < 0.9);
    bench.drive(-0.2, 0.2, 2, 1e9);
    CHECK(bench.plant->state().velocity.angular.z == Approx(rate).epsilon(1e-6));
    // The turning centre lies behind the middle: that is where the load is.
    const Generalised& u = bench.plant->state().velocity;
    CHECK(-u.linear.y / u.angular.z < 0.0);
  }
}
