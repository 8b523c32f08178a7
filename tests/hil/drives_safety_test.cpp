// SPDX-License-Identifier: BSD-3-Clause
// When the motors stop and when they do not start, with both protocols: one story a case.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/hil/drives_world.hpp"
#include "tests/hil/units.hpp"

namespace sortie::hil::test {

namespace {

using drivers::StopReason;

template <class World>
bool still(const World& world) {
  return std::fabs(world.speed(0)) < 1e-3 && std::fabs(world.speed(1)) < 1e-3;
}

}  // namespace

TEMPLATE_TEST_CASE("drives: while one cannot be enabled none moves, and nothing is tried again", "",
                   CanopenKind, OdriveKind) {
  typename TestType::Config config;
  SECTION("asked anew only") { config.group.rearm_ns = 0; }
  SECTION("with re-arming") { config.group.rearm_ns = 500 * kMs; }
  DrivesWorld<TestType> world(false, config);
  TestType::block(world.node(1), true);
  world.ask(false);
  world.run(3000);
  world.ask(true);
  CHECK(way(world, 60'000) < 1e-3);
  CHECK(world.runtime().group().starts() <= 1);
  CHECK(world.runtime().stop_reason() >= StopReason::drive_fault);
  CHECK_FALSE(world.torque());
  TestType::block(world.node(1), false);
  CHECK(way(world, 10'000) < 1e-3);  // it could now, but nobody has asked since
  world.request();
  CHECK(way(world, 2'000) > 0.3);
}

TEMPLATE_TEST_CASE("drives: one that lives and is not read stops all", "", CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world;
  REQUIRE(world.bring_up());
  TestType::mute(world.node(1), true);
  CHECK(way(world, 60'000) < 0.25);
  CHECK_FALSE(world.torque());
  CHECK(world.runtime().stop_reason() == StopReason::drive_lost);
  TestType::mute(world.node(1), false);
  CHECK(way(world, 5'000) < 1e-3);
  world.request();
  world.run(1500);
  CHECK(world.runtime().running());
}

TEST_CASE("drives: one that hears heartbeats and nothing else is stopped by their end") {
  DrivesWorld<CanopenKind> world;
  REQUIRE(world.bring_up());
  world.node(1).set_hears_heartbeats_alone(true);
  CHECK(way(world, 60'000) < 0.35);
  CHECK_FALSE(world.torque());
  CHECK(world.runtime().line().counters().cuts >= 1);
}

TEST_CASE("drives: an axis that is fed and does not obey is stopped by its watchdog, mute or not") {
  const bool mute = GENERATE(false, true);
  DrivesWorld<OdriveKind> world;
  REQUIRE(world.bring_up());
  world.node(1).set_disobeys(true);
  world.node(1).set_mute(mute);
  if (!mute) world.ask(false);
  world.run(200 + 500 + 300 + 150 + 100);  // its loss, a stop, idle, its watchdog
  CHECK_FALSE(world.torque());
}

TEST_CASE("drives: a fault that is forgotten in a start and comes back is a new one") {
  DrivesWorld<OdriveKind> world;
  REQUIRE(world.bring_up());
  OdriveKind::fault(world.node(0));
  world.run(2000);
  world.ask(false);
  world.run(20);
  world.ask(true);
  while (world.node(0).error() != 0) world.step();
  world.run(60);  // a heartbeat says so
  OdriveKind::fault(world.node(0));
  world.run(1000);
  CHECK(world.runtime().stop_reason() == StopReason::drive_fault);
  CHECK(still(world));
}

TEMPLATE_TEST_CASE("drives: every source renews its own age alone", "", CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world(true);
  REQUIRE(world.bring_up());
  SECTION("flippers do not speak for tracks") {
    world.drive_speaks_ = false;
    CHECK(way(world, 60'000) < 0.25);
    CHECK(world.runtime().stop_reason() == StopReason::command_stale);
  }
  SECTION("nor do tracks for flippers") {
    world.flippers_speak_ = false;
    world.run(1000);
    CHECK(world.runtime().stop_reason() == StopReason::command_stale);
  }
  SECTION("what is no number renews nothing") {
    world.drive_.left_m_s = std::numeric_limits<double>::quiet_NaN();
    CHECK(way(world, 60'000) < 0.25);
    CHECK(world.runtime().stop_reason() == StopReason::command_stale);
  }
  SECTION("nor does what was made long ago") {
    world.drive_speaks_ = false;
    rt::DriveCommand old = world.drive_;
    const rt::Nanoseconds made_ns = world.now();
    for (int ms = 0; ms < 2000; ++ms) {
      old.stamp_ns = made_ns;
      const Status status = world.runtime().set(old, world.now());
      CHECK(status == (world.now() - made_ns <= 200 * kMs ? Status::ok : Status::stale));
      world.step();
    }
    CHECK(still(world));
  }
  SECTION("a source that has said off may fall silent") {
    world.flipper_.flags = 0;
    world.run(50);
    world.flippers_speak_ = false;
    CHECK(way(world, 1000) > 0.4);
    CHECK(world.runtime().running());
  }
}

TEMPLATE_TEST_CASE("drives: an emergency stop forgets what was asked", "", CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world;
  SECTION("while they run") {
    REQUIRE(world.bring_up());
    world.runtime().press(true);
    CHECK(way(world, 1000) < 0.1);
  }
  SECTION("while they come up") {
    world.ask(false);
    world.run(3000);
    world.ask(true);
    world.run(20);
    world.runtime().press(true);
    CHECK(way(world, 1000) < 1e-3);
  }
  SECTION("while a request waits") {
    world.ask(false);
    world.run(100);
    world.ask(true);
    world.run(20);
    world.runtime().press(true);
    CHECK(way(world, 3000) < 1e-3);
  }
  SECTION("and what is asked while it is pressed") {
    REQUIRE(world.bring_up());
    world.runtime().press(true);
    world.run(1000);
    world.request();
    world.run(500);
  }
  CHECK_FALSE(world.torque());
  CHECK(world.runtime().stop_reason() == StopReason::emergency_stop);
  world.runtime().press(false);
  CHECK(way(world, 5000) < 1e-3);
  CHECK_FALSE(world.runtime().running());
  world.request();
  world.run(1500);
  CHECK(world.runtime().running());
}

TEMPLATE_TEST_CASE("drives: a request that waits is spoilt by what would end a run", "", CanopenKind,
                   OdriveKind) {
  DrivesWorld<TestType> world;
  REQUIRE(world.bring_up());
  SECTION("its source falls silent before the stop is over") {
    world.request();
    world.run(5);
    REQUIRE(world.runtime().group().state() == drivers::GroupState::stopping);
    // A stop that lasts: the wheels are pushed.
    for (const std::size_t i : {0, 1})
      world.axis(i).config().slope_s2 = (i == 0 ? 5.9 : -5.9) * TestType::kPerM;
    world.drive_speaks_ = false;
    world.run(400);
    REQUIRE(world.runtime().group().state() == drivers::GroupState::stopping);
    for (const std::size_t i : {0, 1}) world.axis(i).config().slope_s2 = 0.0;
    world.drive_speaks_ = true;
    world.run(3000);
  }
  SECTION("a drive fails while it waits for another") {
    world.ask(false);
    world.run(1500);
    world.node(1).set_power(false);
    world.run(1000);
    world.node(1).set_power(true);
    world.ask(true);
    world.run(50);
    REQUIRE(world.runtime().group().state() == drivers::GroupState::waiting);
    TestType::fault(world.node(0));
    world.run(6000);
  }
  CHECK_FALSE(world.runtime().running());
  CHECK(still(world));
}

TEST_CASE("drives: no axis is put under torque for its proof while the emergency stop is pressed") {
  DrivesWorld<OdriveKind> world(true);
  const bool in_the_middle = GENERATE(false, true);
  world.ask(false);
  if (in_the_middle) {
    while (!world.torque()) world.step();
    world.runtime().press(true);
    world.run(100);
  } else {
    world.runtime().press(true);
  }
  for (int ms = 0; ms < 5000; ++ms) {
    world.step();
    REQUIRE_FALSE(world.torque());
  }
  world.runtime().press(false);
  world.run(2000);
  world.request();
  world.run(800);
  CHECK(world.runtime().running());
}

TEMPLATE_TEST_CASE("drives: a process that did not run for a while can be asked again", "", CanopenKind,
                   OdriveKind) {
  for (const int ms : {50, 120, 200, 1000, 12'000}) {
    CAPTURE(ms);
    DrivesWorld<TestType> world(true);
    REQUIRE(world.bring_up());
    world.starved_ = true;
    world.run(ms);
    world.starved_ = false;
    if (ms > 200) {
      CHECK_FALSE(world.torque());
      CHECK(way(world, 5000) < 0.35);  // what still rolled
      CHECK(still(world));
      CHECK_FALSE(world.runtime().running());
    }
    world.run(3000);
    world.request();
    world.run(1500);
    CHECK(world.runtime().running());
  }
}

TEMPLATE_TEST_CASE("drives: a bus that was gone can be used again", "", CanopenKind, OdriveKind) {
  DrivesWorld<TestType> world(true);
  REQUIRE(world.bring_up());
  world.set_bus_off(true);
  CHECK(way(world, 3000) < 0.35);
  CHECK_FALSE(world.torque());
  world.set_bus_off(false);
  CHECK(way(world, 4000) < 1e-3);
  world.request();
  world.run(1500);
  CHECK(world.runtime().running());
}

TEMPLATE_TEST_CASE("drives: faults are forgotten by a start, also where drives re-arm by themselves", "",
                   CanopenKind, OdriveKind) {
  typename TestType::Config config;
  config.group.rearm_ns = 300 * kMs;
  DrivesWorld<TestType> world(true, config);
  REQUIRE(world.bring_up());
  TestType::fault(world.node(0));
  world.run(100);
  CHECK_FALSE(world.runtime().running());
  world.run(3000);
  CHECK(world.runtime().running());
}

}  // namespace sortie::hil::test
