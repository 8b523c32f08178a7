// SPDX-License-Identifier: BSD-3-Clause
// Axes on CANSimple at both ends: found, proved, started; lost, faulty, silent: who stops, and when.
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>

#include "drivers/odrive_dbc.hpp"
#include "tests/hil/odrive_rig.hpp"

using namespace sortie;
using drivers::StopReason;
using drivers::odrive::AxisPhase;
using hil::AxisNode;
using hil::test::OdriveRig;

namespace {

constexpr int kLostMs = 150 + 10 + 2;  // silence, a cycle, and the way
constexpr int kRollMs = 1200;          // out, without torque

}  // namespace

TEST_CASE("odrive: frames are those of the protocol, byte for byte") {
  // Worked by hand from the protocol's table: number << 5 | command, floats of IEEE 754, little end first.
  drivers::CanFrame frame;
  frame.size = 8;
  REQUIRE(drivers::set_can_field(frame, drivers::odrive::kSetInputVelSignals[0], -2.5) == Status::ok);
  REQUIRE(drivers::set_can_field(frame, drivers::odrive::kSetInputVelSignals[1], 0.25) == Status::ok);
  const std::uint8_t velocity[] = {0x00, 0x00, 0x20, 0xC0, 0x00, 0x00, 0x80, 0x3E};
  CHECK(std::memcmp(frame.data, velocity, 8) == 0);
  const std::uint8_t heartbeat[] = {0x01, 0x00, 0x00, 0x80, 0x08, 0x00, 0x01, 0x00};
  std::memcpy(frame.data, heartbeat, 8);
  CHECK(drivers::read_can_field(frame, drivers::odrive::kHeartbeatSignals[0]) == 0x8000'0001);
  CHECK(drivers::read_can_field(frame, drivers::odrive::kHeartbeatSignals[1]) == 8);
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  rig.run(20);
  const auto has = [&](std::uint32_t id) {
    return std::any_of(rig.seen().begin(), rig.seen().end(),
                       [&](const drivers::CanFrame& f) { return f.id == id && f.size == 8 && f.flags == 0; });
  };
  // Heartbeat, state, estimates, mode, speed or position, limits, forgetting; of axis 1, and 11.
  for (const std::uint32_t id : {0x021u, 0x027u, 0x029u, 0x02Bu, 0x02Du, 0x02Fu, 0x038u, 0x16Cu}) {
    CAPTURE(id);
    CHECK(has(id));
  }
  CHECK_FALSE(has(0x02Cu));
  CHECK_FALSE(has(0x16Du));
}

TEST_CASE("odrive: axes are found, their watchdogs proved, and they run as they are told") {
  OdriveRig rig;
  rig.run(1500);
  CHECK(rig.none_under_torque());
  CHECK(rig.fastest() == 0.0);  // not even for the proof
  for (std::size_t i = 0; i < OdriveRig::kAxes; ++i) {
    CAPTURE(i);
    CHECK(rig.axis(i).phase() == AxisPhase::ready);
    CHECK(rig.node(i).counters().watchdog >= 1);
    // 100 ms, and what the heartbeat took to tell.
    CHECK(rig.axis(i).watchdog_ns() >= 100 * OdriveRig::kMs);
    CHECK(rig.axis(i).watchdog_ns() <= 162 * OdriveRig::kMs);
    CHECK(rig.node(i).velocity_limit() == 40.0);
    CHECK(rig.node(i).current_limit() == 20.0);
  }
  rig.armed_ = true;
  rig.run(1000);
  CHECK(rig.axes().running());
  CHECK(rig.motor(0).turns_s == Approx(5.0));
  CHECK(rig.motor(1).turns_s == Approx(-3.0));
  CHECK(rig.motor(2).turns == Approx(4.0).margin(1e-3));
  CHECK(rig.axis(0).reading().turns_s == Approx(5.0));
  rig.targets_[0] = 1e300;  // no motor turns faster than its limit
  rig.run(1000);
  CHECK(rig.motor(0).turns_s == Approx(40.0));
}

TEST_CASE("odrive: an axis whose watchdog does not stop it never runs") {
  hil::AxisNodeConfig axis;
  axis.watchdog_ns = 0;
  OdriveRig rig({}, axis);
  rig.armed_ = true;
  rig.run(5000);
  CHECK_FALSE(rig.axes().running());
  CHECK(rig.fastest() == 0.0);
  CHECK(rig.axis(0).phase() != AxisPhase::ready);
  CHECK(rig.axis(0).counters().unguarded >= 1);
  CHECK(rig.axis(0).counters().set_ups == 0);
  SECTION("nor does one that is slower than the silence allowed") {
    hil::AxisNodeConfig slow;
    slow.watchdog_ns = 400 * OdriveRig::kMs;
    OdriveRig other({}, slow);
    other.run(2000);
    CHECK(other.axis(0).counters().unguarded >= 1);
    CHECK(other.axis(0).counters().set_ups == 0);
  }
}

TEST_CASE("odrive: when the process dies, every axis stops by its own watchdog") {
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  rig.run(100);
  rig.kill();
  rig.run(100 + 12);  // the last frame may be a cycle old
  CHECK(rig.none_under_torque());
  rig.run(kRollMs);
  CHECK(rig.motor(0).turns_s == 0.0);
  // Its successor begins disarmed, sets all up anew, and runs only when it has been asked after that.
  rig.restart();
  rig.armed_ = true;
  rig.fastest();
  rig.run(2000);
  CHECK_FALSE(rig.axes().running());
  CHECK(rig.fastest() < 1e-5);  // turns as floats
  CHECK(rig.bring_up());
}

TEST_CASE("odrive: an axis without power stops the others in time, comes back, and waits to be asked") {
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  rig.run(200);
  rig.node(1).set_power(false);
  rig.run(kLostMs);
  CHECK(rig.axes().stop_reason() == StopReason::drive_lost);
  rig.run(110);  // the ramp from 5 turns/s
  CHECK(rig.motor(0).turns_s == Approx(0.0).margin(0.06));
  rig.run(100);
  CHECK_FALSE(rig.node(0).command().on);  // let go once at rest
  rig.node(1).set_power(true);
  rig.run(2500);
  CHECK(rig.axis(1).phase() == AxisPhase::ready);
  CHECK(rig.axis(1).counters().lost == 1);
  CHECK_FALSE(rig.axes().running());  // still asked for, but not anew
  CHECK(rig.none_under_torque());
  rig.armed_ = false;
  rig.run(10);
  rig.armed_ = true;
  rig.run(500);
  CHECK(rig.axes().running());
  CHECK(rig.motor(0).turns_s == Approx(5.0));
  CHECK(rig.axes().group().stops() == 1);
}

TEST_CASE("odrive: a reboot between two heartbeats is noticed, at rest as well") {
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  rig.run(500);
  rig.armed_ = false;
  rig.run(1000);
  REQUIRE(rig.axis(0).reading().turns > 1.0);
  rig.node(0).set_power(false);
  rig.run(3);
  rig.node(0).set_power(true);
  rig.node(0).config().boot_ns = 30 * OdriveRig::kMs;  // between two heartbeats
  rig.run(50);
  CHECK(rig.axis(0).counters().restarts == 1);
  CHECK(rig.axis(0).phase() != AxisPhase::ready);
  rig.run(1500);
  CHECK(rig.node(0).velocity_limit() == 40.0);  // which it had forgotten
  CHECK(rig.axis(0).phase() == AxisPhase::ready);
}

TEST_CASE("odrive: an error stops the others and is forgotten only when asked anew") {
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  rig.run(200);
  rig.node(0).fail(0x40, 2);
  rig.run(50 + 12);  // the next heartbeat, and a cycle
  CHECK(rig.axes().stop_reason() == StopReason::drive_fault);
  CHECK(rig.axis(0).error() == 0x40);
  CHECK(rig.axis(0).counters().faults == 1);
  rig.run(1000);
  CHECK(rig.node(0).error() == 0x40);
  CHECK(rig.none_under_torque());
  rig.armed_ = false;
  rig.run(10);
  rig.armed_ = true;
  rig.run(500);  // two attempts come too early
  CHECK(rig.axes().running());
  CHECK(rig.all_under_torque());
}

TEST_CASE("odrive: an axis that falls idle without a word stops the others") {
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  rig.run(200);
  rig.node(1).leave();
  rig.run(50 + 12);
  CHECK(rig.axes().stop_reason() == StopReason::drive_left);
  rig.run(700);
  CHECK(rig.none_under_torque());
}

TEST_CASE("odrive: a deaf axis stops by its watchdog, and the others with it") {
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  rig.run(200);
  rig.node(0).set_deaf(true);
  rig.run(100 + 50 + 22);
  CHECK_FALSE(rig.node(0).command().on);
  CHECK(rig.axes().stop_reason() == StopReason::drive_fault);
  rig.run(700);
  CHECK(rig.none_under_torque());
}

TEST_CASE("odrive: without the bus every axis stops, and all come back with it") {
  drivers::odrive::UgvAxesConfig config;
  config.group.rearm_ns = 500 * OdriveRig::kMs;
  OdriveRig rig(config);
  REQUIRE(rig.bring_up());
  rig.run(200);
  rig.stub().set_plugged(rig.group_port(), false);
  rig.run(kLostMs);
  CHECK(rig.none_under_torque());
  CHECK_FALSE(rig.axes().running());
  rig.stub().set_plugged(rig.group_port(), true);
  rig.run(3500);
  CHECK(rig.axes().running());
  CHECK(rig.motor(0).turns_s == Approx(5.0));
}

TEST_CASE("odrive: stale targets stop the axes, and so does the emergency stop until released") {
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  rig.commands_ = false;
  rig.run(200 + 12);
  CHECK(rig.axes().stop_reason() == StopReason::command_stale);
  rig.run(700);
  CHECK(rig.none_under_torque());
  rig.commands_ = true;
  REQUIRE(rig.bring_up());
  rig.axes().press(true);
  rig.run(700);
  CHECK(rig.none_under_torque());
  rig.armed_ = false;
  rig.run(10);
  rig.armed_ = true;
  rig.run(300);
  CHECK_FALSE(rig.axes().running());
  CHECK(rig.axes().stop_reason() == StopReason::emergency_stop);
  rig.axes().press(false);
  rig.run(300);
  CHECK_FALSE(rig.axes().running());  // asked for, but not since the release
  rig.armed_ = false;
  rig.run(20);
  rig.armed_ = true;
  rig.run(300);
  CHECK(rig.axes().running());
}

TEST_CASE("odrive: what no axis can mean is counted and changes nothing") {
  OdriveRig rig;
  REQUIRE(rig.bring_up());
  const drivers::odrive::AxisReading before = rig.axis(0).reading();
  drivers::CanFrame frame;
  frame.id = 0x029;
  frame.size = 8;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(frame.data, &nan, 4);
  CHECK(rig.axes().take(frame, 0));
  frame.size = 7;
  CHECK(rig.axes().take(frame, 0));
  frame.size = 8;
  frame.flags = drivers::kCanRemote;
  CHECK(rig.axes().take(frame, 0));
  frame.flags = drivers::kCanExtended;
  CHECK_FALSE(rig.axes().take(frame, 0));
  frame.flags = 0;
  frame.id = 0x0C1;  // axis 6
  CHECK_FALSE(rig.axes().take(frame, 0));
  CHECK(rig.axis(0).counters().malformed == 3);
  CHECK(rig.axis(0).reading().number == before.number);
  CHECK(rig.axis(0).reading().turns == before.turns);
  CHECK(rig.axes().line().counters().other_frames == 2);
}

TEST_CASE("odrive: settings that cannot be used are refused") {
  using drivers::odrive::AxisConfig;
  const auto group = [](const AxisConfig& a, const AxisConfig& b) {
    const AxisConfig axes[] = {a, b};
    static_cast<void>(drivers::odrive::AxisLine(10 * OdriveRig::kMs, axes));
  };
  const AxisConfig good{.node = 2};
  CHECK_NOTHROW(group({.node = 1}, good));
  CHECK_THROWS(group({.node = 64}, good));
  CHECK_THROWS(group({.node = 2}, good));
  CHECK_THROWS(group({.node = 1, .velocity_limit_turn_s = 0.0}, good));
  CHECK_THROWS(group({.node = 1, .current_limit_a = std::numeric_limits<double>::quiet_NaN()}, good));
  CHECK_THROWS(group({.node = 1, .silence_ns = OdriveRig::kMs}, good));
}
