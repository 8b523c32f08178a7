// SPDX-License-Identifier: BSD-3-Clause
// The CANopen master against simulated drives: how they come up, what each loss does and how soon, and the
// way back without a restart.
#include <catch2/catch.hpp>

#include "tests/hil/canopen_rig.hpp"

using namespace sortie;
using drivers::canopen::DrivePhase;
using drivers::canopen::DriveState;
using drivers::canopen::StopReason;
using hil::test::CanopenRig;

namespace {

// The promise of Master: heartbeat time-out, one SYNC period, and frames on their way.
constexpr int kStopMs = 150 + 10 + 3;
// A motor at 5000 increments a second on its quick-stop ramp.
constexpr int kRampMs = 5000 / 400 + 2;

bool canopen_enabled(CanopenRig& rig) {
  for (std::size_t i = 0; i < 4; ++i) {
    if (rig.node(i).state() == DriveState::operation_enabled) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("canopen: drives are found, set up, and run as they are told") {
  CanopenRig rig;
  rig.run(1500);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(rig.master().drive(i).phase() == DrivePhase::operational);
    CHECK(rig.node(i).state() == DriveState::switch_on_disabled);
    CHECK(rig.node(i).dictionary().value(0x1016, 1) == (127u << 16u | 150u));
    CHECK(rig.node(i).dictionary().value(0x1017) == 50);
  }
  CHECK(rig.all_still());
  CHECK(rig.master().stop_reason() == StopReason::disarmed);
  rig.armed_ = true;
  rig.run(400);
  CHECK(rig.master().running());
  CHECK(rig.motor(0).velocity == 5000);
  CHECK(rig.motor(1).velocity == -3000);
  CHECK(std::abs(rig.motor(2).position - 2000) < 20);
  CHECK(std::abs(rig.motor(3).position + 2000) < 20);
  CHECK(rig.master().drive(0).reading().position > 1000);
  rig.armed_ = false;
  rig.run(10 + kRampMs + 3);
  CHECK(rig.all_still());
  CHECK_FALSE(canopen_enabled(rig));
  CHECK(rig.master().counters().stops == 0);
  CHECK(rig.stub().stats().collisions == 0);
}

TEST_CASE("canopen: when the process dies, every drive stops by its own heartbeat consumer") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.run(100);
  rig.kill_master();
  rig.run(150 + 50);  // the last heartbeat may be as old as its period
  CHECK_FALSE(canopen_enabled(rig));
  rig.run(kRampMs);
  CHECK(rig.all_still());
  for (std::size_t i = 0; i < 4; ++i) CHECK(rig.node(i).counters().heartbeat_lost == 1);
  // Its successor begins disarmed, sets all up anew, and runs only when it has been asked after that.
  rig.restart_master();
  rig.armed_ = true;
  rig.run(2000);
  CHECK(rig.all_still());
  CHECK_FALSE(rig.master().running());
  CHECK(rig.bring_up());
}

TEST_CASE("canopen: a drive without power stops the others in time, comes back, and waits to be asked") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.run(100);
  rig.node(1).set_power(false);
  rig.run(kStopMs + kRampMs);
  CHECK(rig.master().stop_reason() == StopReason::drive_lost);
  CHECK(rig.motor(0).velocity == 0);
  CHECK_FALSE(canopen_enabled(rig));
  rig.node(1).set_power(true);
  rig.run(2500);
  CHECK(rig.master().drive(1).phase() == DrivePhase::operational);
  CHECK_FALSE(rig.master().running());  // still asked for, but not anew
  CHECK(rig.all_still());
  rig.armed_ = false;
  rig.run(10);
  rig.armed_ = true;
  rig.run(300);
  CHECK(rig.master().running());
  CHECK(rig.motor(0).velocity == 5000);
  CHECK(rig.master().counters().stops == 1);
}

TEST_CASE("canopen: with rearm_ns the drives run again by themselves, once all have been well for so long") {
  drivers::canopen::MasterConfig config;
  config.arming.rearm_ns = 1000 * CanopenRig::kMs;
  CanopenRig rig({}, config);
  REQUIRE(rig.bring_up());
  rig.node(0).set_power(false);
  rig.run(400);
  CHECK(rig.master().stop_reason() == StopReason::drive_lost);
  rig.node(0).set_power(true);
  rig.run(900);
  CHECK_FALSE(rig.master().running());
  rig.run(2000);
  CHECK(rig.master().running());
  CHECK(rig.motor(0).velocity == 5000);
}

TEST_CASE("canopen: a drive that boots between two heartbeats is noticed") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.node(0).set_power(false);
  rig.run(3);
  rig.node(0).set_power(true);
  rig.run(20 + kRampMs);
  CHECK(rig.master().stop_reason() == StopReason::drive_lost);
  CHECK(rig.motor(1).velocity == 0);
  CHECK(rig.master().drive(0).counters().restarts == 1);
}

TEST_CASE("canopen: a fault stops the others within a cycle and is reset only when asked anew") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.run(600);
  rig.node(2).fail(0x2310);
  rig.run(20 + kRampMs);
  CHECK_FALSE(canopen_enabled(rig));
  CHECK(rig.all_still());
  CHECK(rig.master().stop_reason() == StopReason::drive_emergency);  // it comes before the status word
  CHECK(rig.master().drive(2).emergency().code == 0x2310);
  rig.run(1000);
  CHECK(rig.node(2).state() == DriveState::fault);
  rig.armed_ = false;
  rig.run(10);
  rig.armed_ = true;
  rig.run(300);
  CHECK(rig.master().running());
  CHECK(rig.node(2).state() == DriveState::operation_enabled);
  CHECK(rig.master().drive(2).emergency().code == 0);
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
  CHECK(rig.master().running());
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
  rig.run(20 + kRampMs);
  CHECK(rig.motor(1).velocity == 0);
  CHECK_FALSE(rig.master().running());
}

TEST_CASE("canopen: a mute drive is stopped by us, and the rest with it") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.node(3).set_mute(true);
  rig.run(kStopMs + kRampMs);
  CHECK(rig.master().stop_reason() == StopReason::drive_lost);
  CHECK(rig.motor(0).velocity == 0);
  CHECK(rig.motor(1).velocity == 0);
}

TEST_CASE("canopen: without the bus every drive stops, and all come back with it") {
  drivers::canopen::MasterConfig config;
  config.arming.rearm_ns = 500 * CanopenRig::kMs;
  CanopenRig rig({}, config);
  REQUIRE(rig.bring_up());
  rig.stub().set_plugged(rig.master_port(), false);
  rig.run(150 + 50 + kRampMs);
  CHECK(rig.all_still());
  rig.run(100);
  CHECK_FALSE(rig.master().running());
  rig.run(3000);
  rig.stub().set_plugged(rig.master_port(), true);
  rig.run(4000);
  CHECK(rig.master().running());
  CHECK(rig.motor(0).velocity == 5000);
}

TEST_CASE("canopen: stale targets stop the drives, and so does the emergency stop until released") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  rig.commands_ = false;
  rig.run(200 + 10 + kRampMs + 3);
  CHECK(rig.master().stop_reason() == StopReason::command_stale);
  CHECK(rig.all_still());
  rig.commands_ = true;
  REQUIRE(rig.bring_up());
  rig.master().stop(true);
  rig.run(10 + kRampMs + 3);
  CHECK(rig.all_still());
  rig.armed_ = false;
  rig.run(20);
  rig.armed_ = true;
  rig.run(500);
  CHECK(rig.all_still());
  rig.master().stop(false);
  rig.run(300);
  CHECK(rig.motor(0).velocity == 5000);
}

TEST_CASE("canopen: another node's frames are counted, and move nothing") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  const auto unknown = rig.master().counters().unknown_node;
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
  CHECK(rig.master().counters().unknown_node == unknown + 2);
  CHECK(rig.master().drive(0).counters().malformed == 1);
  CHECK(rig.master().running());
}

TEST_CASE("canopen: a drive without an object that the safe stop needs is refused, by name") {
  CanopenRig rig;
  rig.run(2);  // booted
  rig.node(1).dictionary().remove(0x1016, 1);
  rig.run(1500);
  const drivers::canopen::Drive& drive = rig.master().drive(1);
  CHECK(drive.counters().refused >= 1);
  CHECK(drive.failure().key == drivers::canopen::ObjectKey{0x1016, 1});
  CHECK(drive.failure().found == drivers::canopen::kAbortNoObject);
  rig.armed_ = true;
  rig.run(100);
  rig.armed_ = false;
  rig.run(100);
  rig.armed_ = true;
  rig.run(500);
  CHECK_FALSE(rig.master().running());
  CHECK(rig.master().stop_reason() == StopReason::not_ready);
}

TEST_CASE("canopen: lost and destroyed frames are survived, and the drives run on") {
  drivers::CanStubConfig bus;
  bus.seed = 77;
  bus.faults.wire_error = 0.02;
  bus.faults.loss = 0.002;
  drivers::canopen::MasterConfig config;
  config.arming.rearm_ns = 200 * CanopenRig::kMs;
  CanopenRig rig(bus, config);
  rig.bring_up();
  int running = 0;
  for (int i = 0; i < 1000; ++i) {
    rig.run(10);
    if (rig.master().running()) ++running;
  }
  CHECK(running > 950);
  CHECK(rig.stub().stats().lost > 10);
}

TEST_CASE("canopen: six drives at 100 Hz fit a bus of 500 kbit/s") {
  CanopenRig rig;
  REQUIRE(rig.bring_up());
  const auto before = rig.stub().stats().busy_bits;
  rig.run(1000);
  // 100 SYNCs, 4 x 100 commands and readings, heartbeats: half of what six drives take.
  const double load = static_cast<double>(rig.stub().stats().busy_bits - before) / 500'000.0;
  CHECK(load > 0.15);
  CHECK(load < 0.25);
}
