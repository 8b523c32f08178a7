// SPDX-License-Identifier: BSD-3-Clause
// The runtime's side of CANopen against simulated drives: how they come up, what each loss does and how soon,
// and the way back without a restart.
#include <catch2/catch.hpp>

#include "tests/hil/canopen_rig.hpp"

using namespace sortie;
using drivers::StopReason;
using drivers::canopen::DrivePhase;
using drivers::canopen::DriveState;
using hil::test::CanopenRig;

namespace {

// The line's promise: heartbeat time-out, one SYNC period, and frames on their way.
constexpr int kStopMs = 150 + 10 + 3;
// A motor at 5000 increments a second on its quick-stop ramp.
constexpr int kRampMs = 5000 / 40 + 2;

bool canopen_enabled(CanopenRig& rig) {
  for (std::size_t i = 0; i < 6; ++i) {
    if (rig.node(i).state() == DriveState::operation_enabled) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("canopen: drives are found, set up, and run as they are told") {
  CanopenRig rig;
  rig.run(2500);
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(rig.drive(i).phase() == DrivePhase::operational);
    CHECK(rig.node(i).state() == DriveState::switch_on_disabled);
    CHECK(rig.node(i).dictionary().value(0x1016, 1) == (127u << 16u | 150u));
    CHECK(rig.node(i).dictionary().value(0x1017) == 50);
  }
  CHECK(rig.all_still());
  CHECK(rig.drives().stop_reason() == StopReason::disarmed);
  rig.armed_ = true;
  rig.run(700);
  CHECK(rig.drives().running());
  CHECK(rig.motor(0).velocity == 5000);
  CHECK(rig.motor(1).velocity == -3000);
  CHECK(std::abs(rig.motor(2).position - 2000) < 20);
  CHECK(std::abs(rig.motor(3).position + 2000) < 20);
  CHECK(rig.drive(0).reading().position > 1000);
  rig.armed_ = false;
  rig.run(10 + kRampMs + 10);
  CHECK(rig.all_still());
  CHECK_FALSE(canopen_enabled(rig));
  CHECK(rig.drives().group().stops() == 0);
  CHECK(rig.stub().stats().collisions == 0);
}

TEST_CASE("canopen: when the process dies, every drive stops by its own heartbeat consumer") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.run(100);
  rig.kill();
  rig.run(150 + 60);  // the last heartbeat may be as old as its period
  CHECK_FALSE(canopen_enabled(rig));
  rig.run(kRampMs);
  CHECK(rig.all_still());
  for (std::size_t i = 0; i < 6; ++i) CHECK(rig.node(i).counters().heartbeat_lost == 1);
  // Its successor begins disarmed, sets all up anew, and runs only when it has been asked after that.
  rig.restart();
  rig.armed_ = true;
  rig.run(2000);
  CHECK(rig.all_still());
  CHECK_FALSE(rig.drives().running());
  CHECK(rig.bring_up());
}

TEST_CASE("canopen: a drive without power stops the others in time, comes back, and waits to be asked") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.run(100);
  rig.node(1).set_power(false);
  rig.run(kStopMs + kRampMs);
  CHECK(rig.drives().stop_reason() == StopReason::drive_lost);
  CHECK(rig.motor(0).velocity == 0);
  CHECK_FALSE(canopen_enabled(rig));
  rig.node(1).set_power(true);
  rig.run(2500);
  CHECK(rig.drive(1).phase() == DrivePhase::operational);
  CHECK_FALSE(rig.drives().running());  // still asked for, but not anew
  CHECK(rig.all_still());
  rig.armed_ = false;
  rig.run(10);
  rig.armed_ = true;
  rig.run(500);
  CHECK(rig.drives().running());
  CHECK(rig.motor(0).velocity == 5000);
  CHECK(rig.drives().group().stops() == 1);
}

TEST_CASE("canopen: with rearm_ns the drives run again by themselves, once all have been well for so long") {
  drivers::canopen::UgvNodesConfig config;
  config.group.rearm_ns = 1000 * CanopenRig::kMs;
  CanopenRig rig({}, config);
  REQUIRE(rig.bring_up());
  rig.node(0).set_power(false);
  rig.run(400);
  CHECK(rig.drives().stop_reason() == StopReason::drive_lost);
  rig.node(0).set_power(true);
  rig.run(900);
  CHECK_FALSE(rig.drives().running());
  rig.run(2000);
  CHECK(rig.drives().running());
  CHECK(rig.motor(0).velocity == 5000);
}

TEST_CASE("canopen: a drive that boots between two heartbeats is noticed") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.node(0).set_power(false);
  rig.run(3);
  rig.node(0).set_power(true);
  rig.node(0).config().boot_ns = 30 * CanopenRig::kMs;  // between two heartbeats
  rig.run(30 + 30 + kRampMs);
  CHECK(rig.drives().stop_reason() == StopReason::drive_lost);
  CHECK(rig.motor(1).velocity == 0);
  CHECK(rig.drive(0).counters().restarts == 1);
}

TEST_CASE("canopen: a fault stops the others within a cycle and is reset only when asked anew") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.run(600);
  rig.node(2).fail(0x2310);
  rig.run(30 + kRampMs);
  CHECK_FALSE(canopen_enabled(rig));
  CHECK(rig.all_still());
  CHECK(rig.drives().stop_reason() == StopReason::drive_emergency);  // it comes before the status word
  CHECK(rig.drive(2).emergency().code == 0x2310);
  rig.run(1000);
  CHECK(rig.node(2).state() == DriveState::fault);
  rig.armed_ = false;
  rig.run(10);
  rig.armed_ = true;
  rig.run(300);
  CHECK(rig.drives().running());
  CHECK(rig.node(2).state() == DriveState::operation_enabled);
  CHECK(rig.drive(2).emergency().code == 0);
}

TEST_CASE("canopen: a reset that comes too early is asked for again, with a new edge") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.node(2).fail(0x3210, 3);  // the voltage is still too high for the first three
  rig.run(300);
  rig.armed_ = false;
  rig.run(10);
  rig.armed_ = true;
  rig.run(300);
  CHECK(rig.node(2).state() == DriveState::operation_enabled);
  CHECK(rig.drives().running());
}

TEST_CASE("canopen: the bus carries no speed while the drives are not to run") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.armed_ = false;
  rig.run(20);
  const std::size_t from = rig.seen().size();
  rig.run(500);
  int commands = 0;
  for (std::size_t i = from; i < rig.seen().size(); ++i) {
    const drivers::CanFrame& frame = rig.seen()[i];
    if (frame.id != 0x201 && frame.id != 0x202) continue;
    ++commands;
    CHECK(drivers::canopen::read_le(frame, 2, 4) == 0);
  }
  CHECK(commands > 90);
}

TEST_CASE("canopen: a fault soon after the start stops the others as one later does") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.node(0).fail(0x2310);
  rig.run(30 + kRampMs);
  CHECK(rig.motor(1).velocity == 0);
  CHECK_FALSE(rig.drives().running());
}

TEST_CASE("canopen: a mute drive is stopped by us, and the rest with it") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.node(3).set_mute(true);
  rig.run(kStopMs + kRampMs);
  CHECK(rig.drives().stop_reason() == StopReason::drive_lost);
  CHECK(rig.motor(0).velocity == 0);
  CHECK(rig.motor(1).velocity == 0);
}

TEST_CASE("canopen: without the bus every drive stops, and all come back with it") {
  drivers::canopen::UgvNodesConfig config;
  config.group.rearm_ns = 500 * CanopenRig::kMs;
  CanopenRig rig({}, config);
  REQUIRE(rig.bring_up());
  rig.stub().set_plugged(rig.master_port(), false);
  rig.run(150 + 60 + kRampMs);
  CHECK(rig.all_still());
  rig.run(100);
  CHECK_FALSE(rig.drives().running());
  rig.run(3000);
  rig.stub().set_plugged(rig.master_port(), true);
  rig.run(4000);
  CHECK(rig.drives().running());
  CHECK(rig.motor(0).velocity == 5000);
}

TEST_CASE("canopen: stale targets stop the drives, and so does the emergency stop until released") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.commands_ = false;
  rig.run(200 + 10 + kRampMs + 10);
  CHECK(rig.drives().stop_reason() == StopReason::command_stale);
  CHECK(rig.all_still());
  rig.commands_ = true;
  REQUIRE(rig.bring_up());
  rig.drives().press(true);
  rig.run(10 + kRampMs + 10);
  CHECK(rig.all_still());
  rig.armed_ = false;
  rig.run(20);
  rig.armed_ = true;
  rig.run(500);
  CHECK(rig.all_still());
  CHECK(rig.drives().stop_reason() == StopReason::emergency_stop);
  rig.drives().press(false);
  rig.run(500);
  CHECK(rig.all_still());  // asked for, but not since the release
  CHECK(rig.drives().stop_reason() == StopReason::emergency_stop);
  rig.armed_ = false;
  rig.run(20);
  rig.armed_ = true;
  rig.run(500);
  CHECK(rig.motor(0).velocity == 5000);
}

TEST_CASE("canopen: another node's frames are counted, and move nothing") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  const auto unknown = rig.drives().line().counters().unknown_node;
  drivers::CanFrame frame;
  frame.id = 0x180 + 5;
  frame.size = 8;
  CHECK(rig.listener().send(frame) == Status::ok);
  frame.id = 0x80 + 99;
  CHECK(rig.listener().send(frame) == Status::ok);
  // A reading of the wrong size under a number that is ours.
  frame.id = 0x181;
  frame.size = 3;
  CHECK(rig.listener().send(frame) == Status::ok);
  rig.run(50);
  CHECK(rig.drives().line().counters().unknown_node == unknown + 2);
  CHECK(rig.drive(0).counters().malformed == 1);
  CHECK(rig.drives().running());
}

TEST_CASE("canopen: a drive without an object that the safe stop needs is refused, by name") {
  CanopenRig rig;
  rig.run(160);  // booted
  rig.node(1).dictionary().remove(0x1016, 1);
  rig.run(1500);
  const drivers::canopen::Drive& drive = rig.drive(1);
  CHECK(drive.counters().refused >= 1);
  CHECK(drive.failure().key == drivers::canopen::ObjectKey{0x1016, 1});
  CHECK(drive.failure().found == drivers::canopen::kAbortNoObject);
  rig.armed_ = true;
  rig.run(100);
  rig.armed_ = false;
  rig.run(100);
  rig.armed_ = true;
  rig.run(500);
  CHECK_FALSE(rig.drives().running());
  CHECK(rig.drives().stop_reason() == StopReason::not_ready);
  // It is not waited for without end, and the request is not kept.
  rig.run(5000);
  CHECK(rig.drives().stop_reason() == StopReason::start_failed);
}

TEST_CASE("canopen: lost and destroyed frames are survived, and the drives run on") {
  drivers::CanStubConfig bus;
  bus.seed = 77;
  bus.faults.wire_error = 0.02;
  bus.faults.loss = 0.002;
  drivers::canopen::UgvNodesConfig config;
  config.group.rearm_ns = 200 * CanopenRig::kMs;
  CanopenRig rig(bus, config);
  rig.bring_up();
  int running = 0;
  for (int i = 0; i < 1000; ++i) {
    rig.run(10);
    if (rig.drives().running()) ++running;
  }
  CHECK(running > 950);
  CHECK(rig.stub().stats().lost > 10);
}

TEST_CASE("canopen: six drives at 100 Hz fit a bus of 500 kbit/s") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  const auto before = rig.stub().stats().busy_bits;
  rig.run(1000);
  // 100 SYNCs, 6 x 100 commands and readings, heartbeats.
  const double load = static_cast<double>(rig.stub().stats().busy_bits - before) / 500'000.0;
  CHECK(load > 0.25);
  CHECK(load < 0.32);
}
