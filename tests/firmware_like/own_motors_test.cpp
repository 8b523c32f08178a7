// SPDX-License-Identifier: BSD-3-Clause
// Motors on the robot's own frames: what goes out, how often, and what an emergency stop and a silence end.
#include "firmware_like/parts/own_motors.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "drivers/can_codec.hpp"
#include "drivers/can_frames.hpp"

using namespace sortie;
using firmware::OwnMotors;

namespace {

constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;

class Port final : public drivers::CanBus {
 public:
  Status send(const drivers::CanFrame& frame) noexcept override {
    if (full) return Status::full;
    frames.push_back(frame);
    return off ? Status::disconnected : Status::ok;  // a kernel takes frames while the bus is off
  }
  Status receive(drivers::CanFrame&) noexcept override { return Status::empty; }
  drivers::CanCounters counters() const noexcept override { return {}; }
  std::vector<drivers::CanFrame> frames;
  bool full{}, off{};
};

// One who has commands in every millisecond, or none at all.
struct Rig {
  void run(int ms) {
    port.frames.clear();
    for (int i = 0; i < ms; ++i) {
      now += kMs;
      if (tracks_live) motors.note_tracks(now);
      const bool drive_due = speaks && motors.drive_is_due(now);
      const bool flippers_due = speaks && motors.flippers_are_due(now);
      motors.poll(port, drive_due ? &drive : nullptr, flippers_due ? &flippers : nullptr, pressed, now);
    }
  }
  int sent(std::uint32_t id) const {
    int count = 0;
    for (const drivers::CanFrame& frame : port.frames) count += frame.id == id ? 1 : 0;
    return count;
  }
  /// The fastest that any frame asks for, m/s; whether one says enabled; whether a flipper's does.
  double fastest() const {
    double most = 0.0;
    rt::DriveCommand command;
    std::uint8_t counter = 0;
    for (const drivers::CanFrame& frame : port.frames) {
      if (drivers::decode_drive(frame, command, counter) == Status::ok)
        most = std::max(most, command.left_m_s);
    }
    return most;
  }
  bool flippers_on() const {
    drivers::FlipperPairCommand command;
    for (const drivers::CanFrame& frame : port.frames) {
      if (drivers::decode_flippers(frame, command) == Status::ok && command.flags != 0) return true;
    }
    return false;
  }
  void start() {
    drive.left_m_s = drive.right_m_s = 0.4;
    drive.flags = flippers.flags = 1;
    run(50);
    drive.asked = flippers.asked = 1;
    run(50);
  }

  Port port;
  OwnMotors motors{true};
  rt::DriveCommand drive;
  rt::FlipperCommand flippers;
  bool speaks{true}, pressed{}, tracks_live{true};
  rt::Nanoseconds now{};
};

}  // namespace

TEST_CASE("own motors: commands go out at their pace") {
  Rig rig;
  rig.start();
  rig.run(1000);
  CHECK(rig.sent(drivers::kCanDriveId) == 100);
  CHECK(rig.sent(drivers::kCanFlipperFrontId) == 50);
  CHECK(rig.fastest() == Approx(0.4).margin(1e-3));
  CHECK(rig.flippers_on());
  rig.speaks = false;
  rig.run(1000);
  CHECK(rig.port.frames.empty());  // the motors stop by themselves
}

TEST_CASE("own motors: a pressed emergency stop speaks for itself, and its release starts nothing") {
  Rig rig;
  rig.start();
  rig.speaks = GENERATE(true, false);
  rig.pressed = true;
  rig.run(1000);
  CHECK(rig.sent(drivers::kCanDriveId) == 100);
  CHECK(rig.sent(drivers::kCanFlipperFrontId) == 50);
  CHECK(rig.fastest() == 0.0);
  CHECK_FALSE(rig.flippers_on());
  rig.drive.asked = rig.flippers.asked = 2;  // while it is pressed
  rig.run(100);
  rig.pressed = false;
  rig.speaks = true;
  // Off and on again, as the planner's guard does it, is no request.
  for (const std::uint32_t flags : {1u, 0u, 1u}) {
    rig.drive.flags = flags;
    rig.run(500);
    CHECK(rig.fastest() == 0.0);
    CHECK_FALSE(rig.flippers_on());
  }
  // Each source for itself.
  rig.drive.asked = 3;
  rig.run(100);
  CHECK(rig.fastest() > 0.3);
  CHECK_FALSE(rig.flippers_on());
  rig.flippers.asked = 3;
  rig.run(100);
  CHECK(rig.flippers_on());
}

TEST_CASE("own motors: the first command is obeyed, whatever its number, unless a stop came before") {
  Rig rig;
  const bool pressed_before = GENERATE(false, true);
  const int waited_ms = GENERATE(5, 1000);
  rig.speaks = false;
  rig.pressed = pressed_before;
  rig.run(waited_ms);
  rig.pressed = false;
  rig.run(5);
  rig.speaks = true;
  rig.drive.left_m_s = rig.drive.right_m_s = 0.4;
  rig.drive.flags = rig.flippers.flags = 1;
  rig.drive.asked = rig.flippers.asked = 1;
  rig.run(100);
  CHECK((rig.fastest() > 0.3) == !pressed_before);
  CHECK(rig.flippers_on() == !pressed_before);
}

TEST_CASE("own motors: tracks that fall silent are lost until they are asked for anew") {
  Rig rig;
  rig.start();
  rig.tracks_live = false;
  rig.run(150);
  CHECK(rig.fastest() > 0.3);
  rig.run(500);
  rig.run(100);
  CHECK(rig.fastest() == 0.0);
  rig.tracks_live = true;
  rig.run(1000);
  CHECK(rig.fastest() == 0.0);
  rig.drive.asked = 2;
  rig.run(100);
  CHECK(rig.fastest() > 0.3);
}

TEST_CASE("own motors: what a full queue refuses is counted, and tried again") {
  Rig rig;
  rig.start();
  rig.port.full = true;
  rig.run(100);
  CHECK(rig.motors.drive_counters().refused >= 90);
  rig.port.full = false;
  rig.run(1);
  CHECK(rig.sent(drivers::kCanDriveId) == 1);
}

TEST_CASE("own motors: what is said while the bus is off has numbers of its own") {
  Rig rig;
  rig.start();
  rig.port.off = true;
  rig.run(100);
  rig.port.off = false;
  std::vector<drivers::CanFrame> frames = rig.port.frames;
  REQUIRE(frames.size() > 50);
  rig.run(20);
  frames.insert(frames.end(), rig.port.frames.begin(), rig.port.frames.end());
  int drives = 0, last = -1;
  for (const drivers::CanFrame& frame : frames) {
    rt::DriveCommand command;
    std::uint8_t counter = 0;
    if (drivers::decode_drive(frame, command, counter) != Status::ok) continue;
    CHECK(counter != last);
    last = counter;
    ++drives;
  }
  CHECK(drives > 50);
}
