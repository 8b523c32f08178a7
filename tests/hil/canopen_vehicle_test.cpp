// SPDX-License-Identifier: BSD-3-Clause
// The robot's drives on CANopen at both ends: what the runtime's side reads is what the body did.
#include <catch2/catch.hpp>
#include <limits>

#include "drivers/can_stub.hpp"
#include "drivers/canopen/ugv_drives.hpp"
#include "hil/canopen/vehicle_drives.hpp"

using namespace sortie;

namespace {

constexpr rt::Nanoseconds kCanopenMs = rt::kNanosecondsPerMillisecond;

// A body that does at once what it is told.
class CanopenPuppet final : public hil::VehicleBody {
 public:
  Status set_command(const rt::DriveCommand& command, rt::Nanoseconds) override {
    drive_ = command;
    return Status::ok;
  }
  Status set_flippers(const drivers::FlipperPairCommand& command) override {
    if ((command.flags & 1u) == 0) return Status::ok;
    const std::size_t left = command.pair == drivers::FlipperPair::front ? 0 : 2;
    flippers_.angle_rad[left] = command.left_rad;
    flippers_.angle_rad[left + 1] = command.right_rad;
    return Status::ok;
  }
  void step() override {
    motion_.left_m += 1e-3 * drive_.left_m_s;
    motion_.right_m += 1e-3 * drive_.right_m_s;
  }
  const hil::Motion& motion() const override { return motion_; }
  bool read_flippers(rt::FlipperSample& sample) const override {
    sample = flippers_;
    return true;
  }
  hil::RobotCounters counters() const override { return {}; }

  hil::Motion motion_{};
  rt::DriveCommand drive_{};
  rt::FlipperSample flippers_{};
};

struct CanopenVehicle {
  CanopenVehicle() {
    config.enabled = true;
    body.flippers_.angle_rad[0] = 0.25;
    body.flippers_.torque_n_m[3] = -12.5;
  }
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now += kCanopenMs;
      drivers::CanFrame frame;
      while (ours.receive(frame) == Status::ok) static_cast<void>(runtime.take(frame, now));
      REQUIRE(runtime.set(drive, now) == Status::ok);
      REQUIRE(runtime.set(flippers, now) == Status::ok);
      runtime.poll(now, ours);
      if (runtime.read(track) == Status::ok) ++tracks;
      if (runtime.read(flipper) == Status::ok) ++states;
      drives.show(body);
      while (theirs.receive(frame) == Status::ok) drives.hear(frame, now);
      drives.step(body, now);
      body.step();
      bus.advance(now);
    }
  }

  drivers::CanStub bus;
  drivers::CanBus& ours = bus.attach("runtime");
  drivers::CanBus& theirs = bus.attach("vehicle");
  drivers::canopen::UgvDrives runtime{drivers::canopen::UgvDrivesConfig{}};
  hil::VehicleDrivesConfig config{.enabled = true};
  hil::VehicleDrives drives{config, theirs, true};
  CanopenPuppet body;
  rt::DriveCommand drive{};
  rt::FlipperCommand flippers{};
  rt::TrackSample track{};
  rt::FlipperSample flipper{};
  int tracks = 0, states = 0;
  rt::Nanoseconds now = 0;
};

}  // namespace

TEST_CASE("canopen vehicle: commands arrive, travel and angles come back with every SYNC") {
  CanopenVehicle v;
  v.run(1000);
  CHECK(v.body.motion_.left_m == 0.0);
  CHECK(v.flipper.angle_rad[0] == Approx(0.25).margin(1e-4));
  CHECK(v.flipper.torque_n_m[3] == Approx(-12.5).margin(0.1));
  v.drive.left_m_s = 0.3;
  v.drive.right_m_s = -0.1;
  v.drive.flags = v.flippers.flags = 1;
  v.flippers.angle_rad[1] = -0.4;
  v.flippers.angle_rad[2] = 0.7;
  v.tracks = v.states = 0;
  v.run(1000);
  CHECK(v.runtime.master().running());
  CHECK(v.tracks == Approx(100).margin(1));
  CHECK(v.states == Approx(100).margin(1));
  CHECK(v.body.motion_.left_m > 0.25);
  // The newest sample is at most one SYNC and its way old.
  CHECK(v.track.left_m == Approx(v.body.motion_.left_m).margin(0.3 * 0.013 + 1e-4));
  CHECK(v.track.right_m == Approx(v.body.motion_.right_m).margin(0.1 * 0.013 + 1e-4));
  CHECK(v.flipper.angle_rad[1] == Approx(-0.4).margin(1e-4));
  CHECK(v.flipper.angle_rad[2] == Approx(0.7).margin(1e-4));
  v.drive.flags = 0;
  v.run(50);
  CHECK(v.body.drive_.left_m_s == 0.0);  // the flippers go on
  CHECK(v.runtime.master().running());
}

TEST_CASE("canopen vehicle: travel goes on where the encoder's 32 bits end") {
  drivers::canopen::IncrementCount count;
  CHECK(count.add(2'147'483'600) == 0);
  CHECK(count.add(-2'147'483'596) == 100);
  CHECK(count.add(2'147'483'600) == 0);
  CanopenVehicle v;
  v.body.motion_.left_m = 214'748.36;  // 0.47 cm before it
  v.drive.left_m_s = v.drive.right_m_s = 0.2;
  v.run(1000);
  v.drive.flags = 1;
  v.run(1000);
  CHECK(v.body.motion_.left_m > 214'748.37);
  CHECK(v.track.left_m == Approx(v.body.motion_.left_m - 214'748.36).margin(0.2 * 0.013 + 2e-4));
}

TEST_CASE("canopen vehicle: what is not finite is refused, and what no increment holds is limited") {
  CanopenVehicle v;
  v.run(1000);
  rt::DriveCommand drive;
  drive.left_m_s = std::numeric_limits<double>::quiet_NaN();
  CHECK(v.runtime.set(drive, v.now) == Status::not_finite);
  rt::FlipperCommand flippers;
  flippers.angle_rad[3] = std::numeric_limits<double>::infinity();
  CHECK(v.runtime.set(flippers, v.now) == Status::not_finite);
  drive.left_m_s = 1e300;
  drive.flags = 1;
  CHECK(v.runtime.set(drive, v.now) == Status::ok);
}

TEST_CASE("canopen vehicle: samples of two SYNCs are never put together") {
  CanopenVehicle v;
  v.run(1000);
  v.drive.left_m_s = v.drive.right_m_s = 0.5;
  v.drive.flags = 1;
  v.run(500);
  const int before = v.tracks;
  v.drives.node(1).set_mute(true);  // the right track's readings stay out
  v.run(100);
  CHECK(v.tracks <= before + 1);
}
