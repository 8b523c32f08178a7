// SPDX-License-Identifier: BSD-3-Clause
// What counts as a request, and whose: one story a case.
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/hil/drives_world.hpp"
#include "tests/hil/units.hpp"

namespace sortie::hil::test {
namespace {

using drivers::StopReason;

}  // namespace

TEMPLATE_TEST_CASE("drives: what was asked before the first command came here starts them", "", CanopenKind,
                   OdriveKind) {
  DrivesWorld<TestType> world(false);
  world.ask(true);  // who polls may have missed the commands before it
  world.run(8000);
  CHECK(way(world, 1000) > 0.3);
}

TEMPLATE_TEST_CASE(
    "drives: what was asked during an emergency stop starts nothing, also if nobody was heard before", "",
    CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world(false);
  world.drive_speaks_ = world.flippers_speak_ = false;
  world.runtime().press(true);
  world.run(6000);
  world.ask(true);
  world.run(100);
  world.runtime().press(false);
  world.run(100);
  world.drive_speaks_ = world.flippers_speak_ = true;
  CHECK(way(world, 8000) < 1e-3);
  world.request();
  world.run(1500);
  CHECK(way(world, 1000) > 0.3);
}

TEMPLATE_TEST_CASE("drives: a number that falls asks for nothing", "", CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world(false);
  REQUIRE(world.bring_up());
  world.request();
  world.run(1500);
  REQUIRE(world.runtime().running());
  world.runtime().press(true);
  world.run(1500);
  world.runtime().press(false);
  world.run(1500);
  world.drive_.asked = world.flipper_.asked = 0;  // whoever commands began anew, at once
  CHECK(way(world, 3000) < 1e-3);
  CHECK_FALSE(world.torque());
}

TEMPLATE_TEST_CASE("drives: a press that was released before anybody looked stops all the same", "",
                   CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world(true);
  REQUIRE(world.bring_up());
  world.runtime().press(true);
  world.runtime().press(false);
  world.run(1500);
  CHECK_FALSE(world.torque());
  CHECK(world.runtime().stop_reason() == StopReason::emergency_stop);
  CHECK(way(world, 3000) < 1e-3);
  world.request();
  world.run(1500);
  CHECK(world.runtime().running());
}

TEMPLATE_TEST_CASE("drives: enabled again, or wanted again, is no request", "", CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world(true);
  REQUIRE(world.bring_up());
  SECTION("after an emergency stop") {
    world.runtime().press(true);
    world.run(1500);
    world.runtime().press(false);
  }
  SECTION("after a drive has lost its power") {
    world.node(1).set_power(false);
    world.run(1500);
    world.node(1).set_power(true);
    world.run(1500);
  }
  // As the planner's guard does it, and then as a mission's pause would.
  for (const std::uint32_t between : {rt::kCommandWanted + 0u, 0u}) {
    world.drive_.flags = world.flipper_.flags = between;
    world.run(300);
    world.drive_.flags = world.flipper_.flags = rt::kCommandEnabled | rt::kCommandWanted;
    CHECK(way(world, 3000) < 1e-3);
    CHECK_FALSE(world.torque());
  }
  ++world.drive_.asked;
  CHECK(way(world, 2000) > 0.3);
}

TEMPLATE_TEST_CASE("drives: what makes the robot wait takes no torque, and lets nothing be driven", "",
                   CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world(false);
  REQUIRE(world.bring_up());
  world.drive_.flags = rt::kCommandWanted;
  world.run(500);
  CHECK(world.runtime().running());
  CHECK(world.torque());
  CHECK(way(world, 2000) < 1e-3);
  world.drive_.flags = rt::kCommandWanted | rt::kCommandEnabled;
  CHECK(way(world, 1000) > 0.3);
}

TEMPLATE_TEST_CASE("drives: nobody's request revives another's", "", CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world(true);
  world.swing_rad_ = 0.5;
  REQUIRE(world.bring_up());
  world.runtime().press(true);
  world.run(1500);
  world.runtime().press(false);
  world.run(500);
  SECTION("the tracks' the flippers'") {
    ++world.drive_.asked;
    world.run(1000);
    REQUIRE(world.runtime().running());
    const double stands = world.position(2);
    CHECK(way(world, 3000) > 0.3);
    CHECK(world.position(2) == Approx(stands).margin(0.02));
    ++world.flipper_.asked;
    double most = 0.0;
    for (int ms = 0; ms < 3000; ++ms) {
      world.step();
      most = std::max(most, std::fabs(world.position(2) - stands));
    }
    CHECK(most > 0.3);
    CHECK(world.runtime().running());
  }
  SECTION("the flippers' the tracks'") {
    ++world.flipper_.asked;
    world.run(1000);
    REQUIRE(world.runtime().running());
    CHECK(way(world, 3000) < 1e-3);
  }
}

TEMPLATE_TEST_CASE("drives: a request that is not taken up waits for nobody else's", "", CanopenKind,
                   OdriveKind) {
  DrivesWorld<TestType> world(true);
  REQUIRE(world.bring_up());
  world.flippers_speak_ = false;
  world.run(2000);
  REQUIRE_FALSE(world.runtime().running());
  ++world.drive_.asked;  // while the flippers' source is silent nothing can run
  world.run(500);
  world.flippers_speak_ = true;
  world.run(500);
  REQUIRE_FALSE(world.runtime().running());
  ++world.flipper_.asked;
  world.run(1000);
  REQUIRE(world.runtime().running());
  CHECK(way(world, 2000) < 1e-3);
}

TEMPLATE_TEST_CASE("drives: what is asked in a silence does not count when it ends", "", CanopenKind,
                   OdriveKind) {
  DrivesWorld<TestType> world;
  REQUIRE(world.bring_up());
  world.drive_speaks_ = false;
  world.run(1000);
  ++world.drive_.asked;
  world.run(500);
  world.drive_speaks_ = true;
  CHECK(way(world, 2000) < 1e-3);
  ++world.drive_.asked;
  CHECK(way(world, 2000) > 0.3);
}

TEMPLATE_TEST_CASE("drives: those that re-arm by themselves were seen well for so long", "", CanopenKind,
                   OdriveKind) {
  typename TestType::Config config;
  config.group.rearm_ns = 600 * kMs;
  DrivesWorld<TestType> world(false, config);
  REQUIRE(world.bring_up());
  world.drive_speaks_ = false;
  world.run(300);
  world.drive_speaks_ = true;
  while (world.runtime().group().state() != drivers::GroupState::off) world.step();
  world.run(520);
  world.starved_ = true;  // nobody looks
  world.run(90);
  world.starved_ = false;
  world.run(300);
  CHECK_FALSE(world.runtime().running());
  world.run(1500);
  CHECK(world.runtime().running());
}

}  // namespace sortie::hil::test
