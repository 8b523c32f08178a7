// SPDX-License-Identifier: BSD-3-Clause
// What happens to a simulated multirotor: ground, battery, lost rotors, bad commands; and its late fixes.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "hil/uav/multirotor_plant.hpp"
#include "hil/uav/pose_source.hpp"

namespace {
using namespace sortie;
using hil::MultirotorConfig;
using hil::MultirotorPlant;

void command_share(MultirotorPlant& plant, double share) {
  const MultirotorConfig& config = plant.dynamics().config();
  double speeds[hil::kMaxSimulatedRotors];
  for (double& speed : speeds)
    speed = std::sqrt(share * plant.dynamics().mass_kg() * config.gravity_m_s2 / (6 * config.thrust_n_s2));
  plant.command(speeds);
}
}  // namespace

TEST_CASE("The ground catches a multirotor, tells how it came down, and lets it go again") {
  MultirotorPlant plant(hil::firefly_plant(), {0, 0, 1}, 0.0);
  command_share(plant, 0.0);
  for (int i = 0; i < 1000; ++i) REQUIRE(plant.step(1e-3) == Status::ok);
  REQUIRE(plant.touch_down().happened);
  // The rotors need their lag to stop, so the fall begins a little late.
  CHECK(plant.touch_down().sink_m_s == Approx(std::sqrt(2 * 9.81)).epsilon(0.02));
  CHECK(plant.on_ground());
  CHECK(plant.state().p_world_m.z == 0);
  command_share(plant, 1.3);
  for (int i = 0; i < 500; ++i) REQUIRE(plant.step(1e-3) == Status::ok);
  CHECK_FALSE(plant.on_ground());
  CHECK(plant.state().p_world_m.z > 0.05);
}

TEST_CASE("Commands that are no speeds are held within the rotor's range and counted") {
  MultirotorPlant plant(hil::neo11_plant(), {0, 0, 10}, 0.0);
  const double infinity = std::numeric_limits<double>::infinity();
  const double bad[8] = {std::nan(""), -3, infinity, 1e9, 500, 500, 0, 0};
  plant.command(bad);
  CHECK(plant.commands_changed() == 4);
  for (int i = 0; i < 2000; ++i) REQUIRE(plant.step(1e-3) == Status::ok);
  for (std::uint32_t i = 0; i < 6; ++i) {
    CHECK(plant.speed_rad_s(i) >= 0);
    CHECK(plant.speed_rad_s(i) <= 1047.2);
  }
  CHECK(std::isfinite(plant.state().p_world_m.z));
  CHECK(plant.step(std::nan("")) == Status::not_finite);
  CHECK(plant.step(0.2) == Status::out_of_range);
}

TEST_CASE("A battery sags under load and lets rotors turn slower, and a gust acts as long as it should") {
  MultirotorConfig config = hil::neo11_plant();
  config.battery.capacity_as = 200;
  MultirotorPlant plant(config, {0, 0, 100}, 0.0);
  command_share(plant, 1.0);
  double last = 1.0;
  for (int i = 0; i < 3000; ++i) {
    REQUIRE(plant.step(1e-3) == Status::ok);
    if (i % 100 == 0) {
      command_share(plant, 1.0);
      CHECK(plant.voltage_share() <= last + 5e-3);
      last = plant.voltage_share();
    }
  }
  CHECK(last < 0.97);
  CHECK(last > 0.7);
  CHECK(plant.state().p_world_m.z < 100);

  MultirotorPlant blown(hil::neo11_plant(), {0, 0, 100}, 0.0);
  REQUIRE(blown.add_gust({{3.45, 0, 0}, 0.1, 0.5}) == Status::ok);
  for (std::uint32_t i = 0; i < 6; ++i) blown.fail_rotor(i);
  for (int i = 0; i < 1000; ++i) REQUIRE(blown.step(1e-3) == Status::ok);
  CHECK(blown.state().v_world_m_s.x == Approx(3.45 / blown.dynamics().mass_kg() * 0.5).epsilon(1e-9));
}

TEST_CASE("A lost rotor leaves its torque missing") {
  MultirotorPlant plant(hil::neo11_plant(), {0, 0, 100}, 0.0);
  command_share(plant, 1.0);
  plant.fail_rotor(1);  // on the left
  REQUIRE(plant.step(1e-3) == Status::ok);
  const double expected = -3.45 * 9.81 / 6 * 0.28929 / plant.dynamics().inertia_kg_m2().x * 1e-3;
  CHECK(plant.state().w_body_rad_s.x == Approx(expected).epsilon(0.01));
  CHECK(plant.state().w_body_rad_s.x < 0);
}

TEST_CASE("An inertial sensor on the plant measures what its integration needs") {
  MultirotorPlant plant(hil::neo11_plant(), {0, 0, 100}, 0.0);
  command_share(plant, 1.2);
  (void)plant.take_inertial();
  for (int i = 0; i < 100; ++i) REQUIRE(plant.step(1e-3) == Status::ok);
  const hil::InertialTruth mean = plant.take_inertial();
  CHECK(mean.acc_m_s2.z == Approx(plant.state().v_world_m_s.z / 0.1 + 9.81).epsilon(1e-4));
}

TEST_CASE("Fixes come late by what is set, in the share that is set, and a black-out holds") {
  hil::PoseSourceConfig config;
  hil::PoseSource source(config, 5);
  const std::int64_t ms = rt::kNanosecondsPerMillisecond;
  source.black_out(10'000 * ms, 12'000 * ms);
  hil::MultirotorState truth;
  int got = 0;
  double square = 0;
  for (std::int64_t now = 0; now < 100'000 * ms; now += ms) {
    truth.p_world_m.x = static_cast<double>(now) * 1e-9;
    source.observe(now, truth);
    rt::UavFix fix;
    while (source.take(now, fix)) {
      ++got;
      CHECK(now - fix.stamp_ns >= 40 * ms);
      CHECK(now - fix.stamp_ns <= 61 * ms);
      CHECK_FALSE((fix.stamp_ns >= 10'000 * ms && fix.stamp_ns < 12'000 * ms));
      const double off = fix.p_world_m[0] - static_cast<double>(fix.stamp_ns) * 1e-9;
      square += off * off;
    }
  }
  CHECK(got > 1960 * 0.965);
  CHECK(got < 1960 * 0.995);
  CHECK(std::sqrt(square / got) == Approx(0.01).epsilon(0.1));
}

TEST_CASE("An inertial sensor off the origin of a spinning plant feels the spin, as in closed form") {
  const hil::Vec3 arm_m{0.3, -0.1, 0.2};
  MultirotorPlant plant(hil::neo11_plant(), {0, 0, 100}, 0.0);
  MultirotorPlant centred(hil::neo11_plant(), {0, 0, 100}, 0.0);
  plant.set_imu_arm(arm_m);
  // Every other rotor faster: it begins to turn.
  const MultirotorConfig& config = plant.dynamics().config();
  double speeds[hil::kMaxSimulatedRotors]{};
  for (std::uint32_t i = 0; i < config.rotors; ++i)
    speeds[i] = std::sqrt((i % 2 == 0 ? 1.3 : 0.7) * plant.dynamics().mass_kg() * config.gravity_m_s2 /
                          (6 * config.thrust_n_s2));
  for (MultirotorPlant* each : {&plant, &centred}) {
    each->command(speeds);
    for (int i = 0; i < 1000; ++i) REQUIRE(each->step(1e-3) == Status::ok);
    (void)each->take_inertial();
  }
  const hil::Vec3 before = plant.state().w_body_rad_s;
  REQUIRE(plant.step(1e-3) == Status::ok);
  REQUIRE(centred.step(1e-3) == Status::ok);
  const hil::Vec3 after = plant.state().w_body_rad_s;
  REQUIRE(std::fabs(before.z) > 0.5);
  const hil::InertialTruth off = plant.take_inertial();
  const hil::InertialTruth at = centred.take_inertial();
  // Centripetal and tangential acceleration in the middle of the step.
  const hil::Vec3 w = 0.5 * (before + after);
  const hil::Vec3 swing = cross(w, cross(w, arm_m)) + cross(1e3 * (after - before), arm_m);
  const hil::Vec3 felt = off.acc_m_s2 - at.acc_m_s2;
  CHECK(felt.x == Approx(swing.x).margin(1e-5));
  CHECK(felt.y == Approx(swing.y).margin(1e-5));
  CHECK(felt.z == Approx(swing.z).margin(1e-5));
  CHECK(off.gyr_rad_s.z == at.gyr_rad_s.z);
}
