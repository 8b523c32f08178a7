// SPDX-License-Identifier: BSD-3-Clause
// The simulated multirotor against closed forms, a twin, finer steps and its mirror image.
#include "hil/uav/multirotor_plant.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hil/random.hpp"

namespace {
using namespace sortie;
using hil::MultirotorConfig;
using hil::MultirotorDynamics;
using hil::MultirotorPlant;
using hil::MultirotorState;
using hil::Vec3;

double speed_for_weight(const MultirotorConfig& config, double share) {
  return std::sqrt(share * hil::total_mass_kg(config) * config.gravity_m_s2 /
                   (static_cast<double>(config.rotors) * config.thrust_n_s2));
}

// A flight that turns and speeds up about all axes, by commands in steps of 10 ms.
void busy_commands(const MultirotorConfig& config, int period, double* speeds) {
  const double base = speed_for_weight(config, 1.05);
  for (std::uint32_t i = 0; i < config.rotors; ++i) {
    const double phase = 0.11 * period + 1.7 * i;
    speeds[i] = base * (1.0 + 0.03 * rt::sin(phase) + 0.02 * rt::cos(0.37 * phase));
  }
}

MultirotorState busy_flight(const MultirotorConfig& config, double step_s, hil::MultirotorMode mode) {
  MultirotorPlant plant(config, {0, 0, 50}, 0.3);
  plant.set_mode(mode);
  plant.set_wind({1.0, -2.0, 0.5});
  const int inner = static_cast<int>(std::lround(0.01 / step_s));
  for (int k = 0; k < 400; ++k) {
    double speeds[hil::kMaxSimulatedRotors];
    busy_commands(config, k, speeds);
    plant.command(speeds);
    for (int i = 0; i < inner; ++i) REQUIRE(plant.step(step_s) == Status::ok);
  }
  return plant.state();
}

double off_m(const MultirotorState& a, const MultirotorState& b) {
  return hil::norm(a.p_world_m - b.p_world_m);
}

const MultirotorConfig kAllHexacopters[] = {hil::neo11_plant(), hil::neo9_plant(), hil::firefly_plant()};
}  // namespace

TEST_CASE("A multirotor without rotors falls as a stone, one at hover speed stays") {
  for (const MultirotorConfig& config : kAllHexacopters) {
    MultirotorPlant stone(config, {1, 2, 100}, 0.0);
    for (std::uint32_t i = 0; i < config.rotors; ++i) stone.fail_rotor(i);
    for (int i = 0; i < 200; ++i) REQUIRE(stone.step(0.01) == Status::ok);
    CHECK(stone.state().p_world_m.z == Approx(100 - 0.5 * config.gravity_m_s2 * 4).epsilon(1e-12));
    CHECK(stone.state().v_world_m_s.z == Approx(-2 * config.gravity_m_s2).epsilon(1e-12));

    MultirotorPlant hovering(config, {1, 2, 3}, 0.4);
    double speeds[hil::kMaxSimulatedRotors];
    for (double& speed : speeds) speed = speed_for_weight(config, 1.0);
    hovering.command(speeds);
    for (int i = 0; i < 10; ++i) REQUIRE(hovering.step(0.01) == Status::ok);
    CHECK(hovering.state().p_world_m.z == Approx(3).margin(1e-4));
    CHECK(hovering.commands_changed() == 0);
  }
}

TEST_CASE("A body that tumbles freely keeps its energy and its angular momentum") {
  MultirotorConfig config = hil::neo11_plant();
  config.drag_n_s2 = 0;
  const MultirotorDynamics dynamics(config);
  MultirotorState state;
  state.w_body_rad_s = {3, -5, 2};
  state.v_world_m_s = {1, 2, 3};
  double speeds[8]{};
  const double still[8]{};
  const Vec3& j = dynamics.inertia_kg_m2();
  const auto energy = [&](const MultirotorState& s) {
    const Vec3& w = s.w_body_rad_s;
    return 0.5 * (j.x * w.x * w.x + j.y * w.y * w.y + j.z * w.z * w.z) +
           dynamics.mass_kg() *
               (0.5 * hil::dot(s.v_world_m_s, s.v_world_m_s) + config.gravity_m_s2 * s.p_world_m.z);
  };
  const auto momentum = [&](const MultirotorState& s) {
    const Vec3& w = s.w_body_rad_s;
    return hil::rotate(s.q_world_body, {j.x * w.x, j.y * w.y, j.z * w.z});
  };
  const double energy_before = energy(state);
  const Vec3 momentum_before = momentum(state);
  for (int i = 0; i < 2000; ++i) dynamics.step_exact(state, speeds, still, {}, 1e-3);
  CHECK(energy(state) == Approx(energy_before).epsilon(1e-9));
  CHECK(hil::norm(momentum(state) - momentum_before) < 1e-8 * hil::norm(momentum_before));
}

TEST_CASE("Rotors follow their commands with the exact lag, up and down, whatever the step") {
  for (const double step_s : {1e-3, 5e-3, 0.05}) {
    const MultirotorDynamics dynamics(hil::firefly_plant());
    MultirotorState state;
    double speeds[8] = {0, 0, 0, 800, 800, 800};
    const double wanted[8] = {500, 500, 500, 500, 500, 500};
    for (int i = 0; i < std::lround(0.1 / step_s); ++i)
      dynamics.step_exact(state, speeds, wanted, {}, step_s);
    CHECK(speeds[0] == Approx(500 * (1 - rt::exp(-0.1 / 0.0125))).epsilon(1e-12));
    CHECK(speeds[3] == Approx(500 + 300 * rt::exp(-0.1 / 0.025)).epsilon(1e-12));
  }
}

TEST_CASE("Each term of the rotor model is as its description says") {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    INFO("seed " << seed);
    hil::Random random(seed, 7);
    const auto draw = [&random](double most) {
      const double x = random.uniform(-most, most);
      const double y = random.uniform(-most, most);
      const double z = random.uniform(-most, most);
      return Vec3{x, y, z};
    };
    const MultirotorConfig config = hil::firefly_plant();
    const MultirotorDynamics dynamics(config);
    MultirotorState state;
    state.v_world_m_s = draw(5);
    state.w_body_rad_s = draw(4);
    const Vec3 angles = draw(1);
    state.q_world_body = hil::from_yaw_pitch_roll(angles.x, angles.y, angles.z);
    const Vec3 wind = draw(4);
    double speeds[8];
    for (double& speed : speeds) speed = random.uniform(100, 838);
    const hil::MultirotorWrench wrench = dynamics.wrench(state, speeds, {wind, {}, {}});
    // The twin works in the world frame, rotor by rotor, as the plugin does.
    const Vec3 up = hil::rotate(state.q_world_body, {0, 0, 1});
    Vec3 force{};
    Vec3 torque{};
    for (std::uint32_t i = 0; i < 6; ++i) {
      const double w = speeds[i];
      const Vec3 arm = hil::rotate(state.q_world_body, config.rotor[i].place_m);
      const Vec3 spin = hil::rotate(state.q_world_body, state.w_body_rad_s);
      const Vec3 relative = state.v_world_m_s + hil::cross(spin, arm) - wind;
      const Vec3 across = relative - hil::dot(relative, up) * up;
      const double thrust = 8.54858e-6 * w * w;
      const Vec3 here = thrust * up - (w * 8.06428e-5) * across;
      force = force + here;
      torque = torque + hil::cross(arm, here) - (config.rotor[i].direction * 0.016 * thrust) * up -
               (w * 1e-6) * across;
    }
    CHECK(hil::norm(wrench.force_world_n - force) < 1e-12 * hil::norm(force));
    CHECK(hil::norm(hil::rotate(state.q_world_body, wrench.torque_body_n_m) - torque) < 1e-12);
  }
}

TEST_CASE("Steps of 10 ms stay within 0.05 mm of the truth over 4 s, and the order is four") {
  for (const MultirotorConfig& config : kAllHexacopters) {
    INFO(config.name);
    const MultirotorState truth = busy_flight(config, 1e-4, hil::MultirotorMode::exact);
    REQUIRE(hil::norm(truth.p_world_m - Vec3{0, 0, 50}) > 0.5);
    const double coarse = off_m(busy_flight(config, 1e-2, hil::MultirotorMode::exact), truth);
    const double fine = off_m(busy_flight(config, 5e-3, hil::MultirotorMode::exact), truth);
    CAPTURE(coarse, fine);
    CHECK(coarse < 5e-5);
    CHECK(coarse / fine > 10);  // 16 for order four
    CHECK(coarse / fine < 24);
  }
}

TEST_CASE("The parity mode has the order of RotorS' own steps: the error halves with the step") {
  const MultirotorConfig config = hil::neo11_plant();
  const MultirotorState truth = busy_flight(config, 1e-4, hil::MultirotorMode::exact);
  const double at_10 = off_m(busy_flight(config, 1e-2, hil::MultirotorMode::parity), truth);
  const double at_5 = off_m(busy_flight(config, 5e-3, hil::MultirotorMode::parity), truth);
  const double at_2 = off_m(busy_flight(config, 2.5e-3, hil::MultirotorMode::parity), truth);
  CAPTURE(at_10, at_5, at_2);
  CHECK(at_10 > 1e-3);
  CHECK(at_10 / at_5 == Approx(2).epsilon(0.15));
  CHECK(at_5 / at_2 == Approx(2).epsilon(0.15));
}

TEST_CASE("No lag and no step makes the plant diverge") {
  for (const double tau_s : {1e-4, 1e-3, 5e-3, 0.0182, 0.04}) {
    for (const double step_s : {1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.04, 0.05}) {
      MultirotorConfig config = hil::neo11_plant();
      config.tau_up_s = tau_s;
      config.tau_down_s = 2 * tau_s;
      const MultirotorDynamics dynamics(config);
      MultirotorState state;
      double speeds[8]{};
      double wanted[8];
      for (int i = 0; i < 200; ++i) {
        for (double& speed : wanted) speed = speed_for_weight(config, i % 2 == 0 ? 0.8 : 1.2);
        dynamics.step_exact(state, speeds, wanted, {}, step_s);
        for (std::uint32_t r = 0; r < 6; ++r) {
          REQUIRE(speeds[r] >= 0);
          REQUIRE(speeds[r] <= speed_for_weight(config, 1.2) * (1 + 1e-12));
        }
      }
      CHECK(hil::norm(state.v_world_m_s) < 60);
    }
  }
}

TEST_CASE("A mirrored vehicle flies the mirrored flight") {
  // Without RotorS' rolling moment: that is a torque along a velocity, which no mirror keeps.
  const MultirotorConfig config = hil::neo9_plant();
  MultirotorConfig mirrored = config;
  for (std::uint32_t i = 0; i < 6; ++i) {
    mirrored.rotor[i].place_m.y = -config.rotor[i].place_m.y;
    mirrored.rotor[i].direction = -config.rotor[i].direction;
  }
  const MultirotorDynamics one(config);
  const MultirotorDynamics two(mirrored);
  MultirotorState a;
  MultirotorState b;
  double speeds_a[8]{};
  double speeds_b[8]{};
  for (int k = 0; k < 300; ++k) {
    double wanted[8];
    busy_commands(config, k, wanted);
    one.step_exact(a, speeds_a, wanted, {{1, 2, 0}, {0.5, 1, 0}, {}}, 0.01);
    two.step_exact(b, speeds_b, wanted, {{1, -2, 0}, {0.5, -1, 0}, {}}, 0.01);
  }
  CHECK(a.p_world_m.x == Approx(b.p_world_m.x).margin(1e-9));
  CHECK(a.p_world_m.y == Approx(-b.p_world_m.y).margin(1e-9));
  CHECK(a.p_world_m.z == Approx(b.p_world_m.z).margin(1e-9));
  CHECK(a.w_body_rad_s.x == Approx(-b.w_body_rad_s.x).margin(1e-9));
}
