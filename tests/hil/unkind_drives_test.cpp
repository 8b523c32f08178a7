// SPDX-License-Identifier: BSD-3-Clause
// What real drives may do, one deed a case: the tables in docs/canopen.md and docs/odrive.md name these
// cases.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/hil/drives_world.hpp"

namespace sortie::hil::test {
namespace {

constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
using drivers::StopReason;

template <class World>
bool still(World& world, int ms) {
  const double from[] = {world.position(0), world.position(1)};
  world.run(ms);
  return std::fabs(world.position(0) - from[0]) < 1e-3 && std::fabs(world.position(1) - from[1]) < 1e-3;
}

/// It stops, stands, and runs again when it is asked anew.
template <class World>
void stops_and_can_be_asked(World& world) {
  world.run(2000);
  CHECK_FALSE(world.runtime().running());
  CHECK(still(world, 2000));
  world.run(2000);
  world.request();
  world.run(1500);
  CHECK(world.runtime().running());
}

template <class Each>
void for_all(DrivesWorld<CanopenKind>& world, Each each) {
  for (std::size_t i = 0; i < world.size(); ++i) each(world.node(i));
}
template <class Each>
void for_all(DrivesWorld<OdriveKind>& world, Each each) {
  for (std::size_t i = 0; i < world.size(); ++i) each(world.node(i));
}

}  // namespace

TEST_CASE("unkind drives: brakes take their time, and one that sticks lets none drive") {
  DrivesWorld<CanopenKind> world;
  for_all(world, [](CanopenNode& node) { node.config().brake = true; });
  SECTION("all open") {
    CHECK(world.bring_up());
    CHECK_FALSE(still(world, 500));
  }
  SECTION("one sticks") {
    world.node(1).set_block(EnableBlock::brake);
    CHECK_FALSE(world.bring_up());
    CHECK(still(world, 2000));
    CHECK(world.runtime().stop_reason() == StopReason::start_failed);
    CHECK_FALSE(world.torque());
  }
}

TEST_CASE("unkind drives: a power stage without voltage lets none drive, and takes one out of a run") {
  DrivesWorld<CanopenKind> world;
  SECTION("from the start") {
    world.node(1).set_block(EnableBlock::no_voltage);
    CHECK_FALSE(world.bring_up());
    CHECK(still(world, 2000));
    world.node(1).set_block(EnableBlock::none);
  }
  SECTION("on the way") {
    REQUIRE(world.bring_up());
    world.node(1).set_block(EnableBlock::no_voltage);
    world.run(1000);
    world.node(1).set_block(EnableBlock::none);
  }
  stops_and_can_be_asked(world);
}

TEMPLATE_TEST_CASE("unkind drives: one that hears nothing any more stops by itself, and all with it", "",
                   CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world;
  REQUIRE(world.bring_up());
  world.node(1).set_deaf(true);
  world.run(500);
  CHECK_FALSE(world.torque());
  world.node(1).set_deaf(false);
  stops_and_can_be_asked(world);
}

TEST_CASE("unkind drives: a fault that needs the power off is not reset by asking") {
  DrivesWorld<CanopenKind> world;
  REQUIRE(world.bring_up());
  world.node(1).fail(0x2310, CanopenNode::kForGood);
  world.run(2000);
  world.request();
  CHECK(still(world, 3000));
  CHECK_FALSE(world.runtime().running());
  world.node(1).set_power(false);
  world.run(500);
  world.node(1).set_power(true);
  stops_and_can_be_asked(world);
}

TEST_CASE("unkind drives: one that misses SYNC or commands has a fault, before its heartbeat consumer acts") {
  DrivesWorld<CanopenKind> world;
  const bool sync = GENERATE(true, false);
  if (sync) world.node(1).config().sync_timeout_ns = 50 * kMs;
  REQUIRE(world.bring_up());
  if (!sync) world.node(1).dictionary().set(0x1400, 5, 50);
  world.starved_ = true;
  world.run(100);
  world.starved_ = false;
  CHECK(world.node(1).counters().faults == 1);
  CHECK(world.node(1).counters().heartbeat_lost == 0);
  stops_and_can_be_asked(world);
}

TEST_CASE("unkind drives: a flipper that does not follow has a fault") {
  DrivesWorld<CanopenKind> world(true);
  world.swing_rad_ = 0.5;
  REQUIRE(world.bring_up());
  world.node(2).dictionary().set(0x6065, 0, 500);
  world.node(2).dictionary().set(0x6066, 0, 20);
  world.axis(2).config().friction_s2 = 1e9;  // it is stuck
  world.run(1500);
  CHECK(world.node(2).counters().faults >= 1);
  world.axis(2).config().friction_s2 = 20.0 * CanopenKind::kPerRad;
  world.node(2).dictionary().set(0x6065, 0, 0);
  stops_and_can_be_asked(world);
}

TEST_CASE("unkind drives: one that does not care for network management is stopped all the same") {
  DrivesWorld<CanopenKind> world;
  world.node(1).config().stopped_matters = false;
  REQUIRE(world.bring_up());
  world.node(1).set_no_readings(true);
  world.run(1000);
  CHECK_FALSE(world.torque());
  world.node(1).set_no_readings(false);
  stops_and_can_be_asked(world);
}

TEST_CASE("unkind drives: an axis whose DC bus rises when it brakes coasts, and can be asked again") {
  DrivesWorld<OdriveKind> world;
  REQUIRE(world.bring_up());
  world.node(1).config().bus_trip_turn_s2 = 40.0;
  world.ask(false);
  world.run(1000);
  CHECK(world.node(1).counters().trips == 1);
  world.node(1).config().bus_trip_turn_s2 = 0.0;
  stops_and_can_be_asked(world);
}

TEST_CASE("unkind drives: an axis that turns faster than its limit allows trips") {
  DrivesWorld<OdriveKind> world;
  REQUIRE(world.bring_up());
  world.axis(1).config().slope_s2 = -100.0 * OdriveKind::kPerM;  // it is pulled
  world.run(3000);
  CHECK(world.node(1).counters().trips >= 1);
  CHECK_FALSE(world.runtime().running());
  CHECK(world.runtime().stop_reason() == StopReason::drive_fault);
}

TEST_CASE("unkind drives: an axis without voltage has an error that comes back until it has some") {
  DrivesWorld<OdriveKind> world;
  REQUIRE(world.bring_up());
  world.node(1).set_voltage(false);
  world.run(1000);
  world.request();
  CHECK(still(world, 3000));
  CHECK_FALSE(world.runtime().running());
  world.node(1).set_voltage(true);
  stops_and_can_be_asked(world);
}

TEST_CASE(
    "unkind drives: firmwares differ in their errors at boot, and in what feeds the watchdog and when it "
    "watches") {
  DrivesWorld<OdriveKind> world;
  SECTION("an error at boot") {
    for_all(world, [](AxisNode& node) { node.config().boot_error = 1; });
  }
  SECTION("targets alone feed") {
    for_all(world, [](AxisNode& node) { node.config().targets_alone_feed = true; });
  }
  SECTION("idle axes are not watched") {
    for_all(world, [](AxisNode& node) { node.config().watched_when_idle = false; });
  }
  CHECK(world.bring_up());
  CHECK_FALSE(still(world, 1000));
  world.lives_ = false;
  world.run(500);
  CHECK_FALSE(world.torque());
}

}  // namespace sortie::hil::test
