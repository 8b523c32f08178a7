// SPDX-License-Identifier: BSD-3-Clause
// How drives come up and go on: set-up, the first moment of a run, restarts of either side, with both
// protocols.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/hil/drives_world.hpp"
#include "tests/hil/units.hpp"

namespace sortie::hil::test {

TEMPLATE_TEST_CASE("drives: a run that begins at speed begins softly", "", CanopenKind, OdriveKind) {
  typename TestType::Config config;
  config.group.rearm_ns = 300 * kMs;
  DrivesWorld<TestType> world(false, config);
  REQUIRE(world.bring_up());
  TestType::fault(world.node(0));
  world.run(300);
  double before = world.speed(1);
  double most_m_s2 = 0.0;
  for (int ms = 0; ms < 3000; ++ms) {
    world.step();
    if (!world.runtime().running()) {
      before = world.speed(1);
      continue;
    }
    if (ms % 20 == 0) {
      most_m_s2 = std::max(most_m_s2, std::fabs(world.speed(1) - before) / 0.02);
      before = world.speed(1);
    }
  }
  CHECK(world.runtime().running());
  CHECK(world.speed(1) == Approx(-0.4).margin(0.01));
  CHECK(most_m_s2 < 3.1);  // 2 m/s^2, in steps of a cycle
}

TEMPLATE_TEST_CASE("drives: flippers that nobody moves do not sink under their load", "", CanopenKind,
                   OdriveKind) {
  DrivesWorld<TestType> world(true);
  for (std::size_t i = 2; i < 6; ++i) {
    // 40 rad/s^2 of load, 0.02 rad of give.
    world.axis(i).config().slope_s2 = -40.0 * TestType::kPerRad;
    world.axis(i).config().friction_s2 = 45.0 * TestType::kPerRad;
    world.axis(i).config().sag_s2 = 5e-4;
  }
  REQUIRE(world.bring_up());
  world.flipper_.flags = 0;
  world.run(200);
  for (std::size_t i = 2; i < 6; ++i) world.axis(i).config().friction_s2 = 1.0 * TestType::kPerRad;
  world.run(500);
  const double stands = world.position(2);
  world.run(30'000);
  CHECK(world.runtime().running());
  CHECK(world.position(2) == Approx(stands).margin(0.02));
}

TEST_CASE("drives: an axis that rebooted unseen is told mode and limits again before it runs") {
  DrivesWorld<OdriveKind> world(true);
  REQUIRE(world.bring_up());
  world.ask(false);
  world.run(1500);
  // Flippers know where they are, so nothing jumps; 30 ms are no silence.
  world.node(3).config().boot_ns = 30 * kMs;
  world.node(3).set_power(false);
  world.run(2);
  world.node(3).set_power(true);
  world.run(500);
  REQUIRE(world.node(3).velocity_limit() == 2.0);
  REQUIRE_FALSE(world.node(3).command().by_position);
  world.request();
  world.run(800);
  CHECK(world.runtime().running());
  CHECK(world.node(3).velocity_limit() == 40.0);
  CHECK(world.node(3).command().by_position);
}

TEST_CASE("drives: a drive that is found under torque is stopped before it is set up") {
  DrivesWorld<CanopenKind> world;
  REQUIRE(world.bring_up());
  world.node(0).dictionary().set(0x1016, 1, 0);  // its consumer is off: it goes on when we die
  world.node(0).dictionary().set(0x605A, 0, 6);  // and keeps its torque
  world.lives_ = false;
  world.run(500);
  REQUIRE(world.node(0).command().on);
  world.restart();
  world.lives_ = true;
  // Its next heartbeat, seven objects, and the quick stop's ramp.
  CHECK(way(world, 8000) < 0.15);
  CHECK_FALSE(world.torque());
  world.request();
  world.run(1500);
  CHECK(world.runtime().running());
}

TEMPLATE_TEST_CASE("drives: a cycle that is longer than a bus may be deaf runs", "", CanopenKind,
                   OdriveKind) {
  typename TestType::Config config;
  if constexpr (std::is_same_v<TestType, CanopenKind>) {
    config.line.sync_period_ns = 100 * kMs;
    config.heartbeat_timeout_ns = 400 * kMs;
  } else {
    config.period_ns = 100 * kMs;
    config.silence_ns = 500 * kMs;
  }
  DrivesWorld<TestType> world(false, config);
  if constexpr (std::is_same_v<TestType, OdriveKind>) {
    for (const std::size_t i : {0, 1}) world.node(i).config().watchdog_ns = 400 * kMs;
  }
  world.ask(false);
  world.run(8000);
  world.ask(true);
  CHECK(way(world, 5000) > 0.5);
  CHECK(world.runtime().running());
}

TEST_CASE("drives: a new process does not feed a drive that it does not know") {
  DrivesWorld<CanopenKind> world;
  REQUIRE(world.bring_up());
  world.node(1).set_hears_heartbeats_alone(true);
  world.lives_ = false;
  world.run(60);
  REQUIRE(world.node(1).command().on);
  world.restart();
  world.lives_ = true;
  world.run(600);
  CHECK_FALSE(world.torque());
}

TEMPLATE_TEST_CASE("drives: travel goes on where a drive counts from zero again", "", CanopenKind,
                   OdriveKind) {
  DrivesWorld<TestType> world;
  REQUIRE(world.bring_up());
  world.run(4000);
  world.ask(false);
  world.run(1500);
  const double before = world.tracks_.left_m;
  REQUIRE(std::fabs(before) > 1.0);
  world.node(0).set_power(false);
  world.axis(0) = DriveAxis(world.axis(0).config());  // its encoder's new zero is where it stands
  world.run(1000);
  world.node(0).set_power(true);
  world.run(5000);
  CHECK(world.tracks_.left_m == Approx(before).margin(0.01));
  world.request();
  world.run(3000);
  CHECK(std::fabs(world.tracks_.left_m - before) > 0.5);
  CHECK(std::fabs(world.tracks_.left_m - before) < 2.0);
}

}  // namespace sortie::hil::test
