// SPDX-License-Identifier: BSD-3-Clause
// The robot's motors on ODrives at both ends: what the runtime's side reads is what the body did.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "drivers/odrive/ugv_axes.hpp"
#include "hil/odrive/vehicle_axes.hpp"
#include "tests/hil/motors_vehicle.hpp"

using namespace sortie;
using OdriveVehicle = hil::test::MotorsVehicle<drivers::odrive::UgvAxes, drivers::odrive::UgvAxesConfig,
                                               hil::VehicleAxes, hil::VehicleAxesConfig>;

TEST_CASE("odrive vehicle: commands arrive, travel and angles come back a hundred times a second") {
  OdriveVehicle v;
  v.run(1500);
  CHECK(v.body.motion_.left_m == 0.0);
  CHECK(v.flipper.angle_rad[0] == Approx(0.25).margin(1e-6));
  CHECK(v.flipper.torque_n_m[3] == Approx(-12.5).margin(1e-5));
  v.drive.left_m_s = 0.3;
  v.drive.right_m_s = -0.1;
  v.drive.flags = v.flippers.flags = 1;
  v.flippers.angle_rad[1] = -0.4;
  v.flippers.angle_rad[2] = 0.7;
  v.run(300);
  v.tracks = v.states = 0;
  v.run(1000);
  CHECK(v.runtime.running());
  CHECK(v.tracks == Approx(100).margin(1));
  CHECK(v.states == Approx(100).margin(1));
  CHECK(v.body.motion_.left_m > 0.3);
  // The newest sample is at most one estimate and its way old; its stamp says how old.
  const double age_s = 1e-9 * static_cast<double>(v.now - v.track.stamp_ns);
  CHECK(age_s < 0.013);
  CHECK(v.track.left_m == Approx(v.body.motion_.left_m - 0.3 * age_s).margin(0.3 * 0.002));
  CHECK(v.track.right_m == Approx(v.body.motion_.right_m + 0.1 * age_s).margin(0.1 * 0.002));
  CHECK(v.flipper.angle_rad[1] == Approx(-0.4).margin(1e-6));
  CHECK(v.flipper.angle_rad[2] == Approx(0.7).margin(1e-6));
  v.drive.flags = 0;
  v.run(50);
  CHECK(v.body.drive_.left_m_s == 0.0);  // the flippers go on
  CHECK(v.runtime.running());
}

TEST_CASE("odrive vehicle: axes that send at different moments are read at one") {
  OdriveVehicle v;
  v.run(1500);
  v.drive.left_m_s = v.drive.right_m_s = 0.5;
  v.drive.flags = 1;
  v.run(300);
  // From here on the right one sends 6 ms after the left: 3 mm of travel.
  v.drives.node(1).set_mute(true);
  v.run(6);
  v.drives.node(1).set_mute(false);
  double worst = 0.0;
  const double apart = v.track.left_m - v.track.right_m;
  for (int i = 0; i < 500; ++i) {
    v.run(1);
    worst = std::max(worst, std::abs(v.track.left_m - v.track.right_m - apart));
  }
  CHECK(worst < 5e-4);
  const int before = v.tracks;
  v.drives.node(1).set_mute(true);  // its estimates stay out
  v.run(100);
  CHECK(v.tracks <= before + 2);
}

TEST_CASE("odrive vehicle: travel goes on where an axis begins to count anew") {
  OdriveVehicle v;
  v.body.motion_.left_m = 12.0;
  v.run(1500);
  CHECK(v.track.left_m == 0.0);
  v.drive.left_m_s = v.drive.right_m_s = 0.5;
  v.drive.flags = 1;
  v.run(2000);
  v.drive.flags = 0;
  v.run(1000);
  const double travelled = v.body.motion_.left_m - 12.0;
  CHECK(v.track.left_m == Approx(travelled).margin(1e-4));
  v.drives.node(0).set_power(false);
  v.run(500);
  v.drives.node(0).set_power(true);
  v.run(3000);
  CHECK(v.track.left_m == Approx(travelled).margin(1e-4));
  const rt::Nanoseconds stamp = v.track.stamp_ns;
  v.run(100);
  CHECK(v.track.stamp_ns > stamp);
}

TEST_CASE("odrive vehicle: after five kilometres a float of turns still counts half a millimetre") {
  OdriveVehicle v;
  v.body.motion_.left_m = 5000.0;  // 10^5 turns
  v.run(1500);
  v.drive.left_m_s = v.drive.right_m_s = 0.05;
  v.drive.flags = 1;
  v.run(3000);
  const double age_s = 1e-9 * static_cast<double>(v.now - v.track.stamp_ns);
  // An axis counts from power-on, so this robot has been on all the way.
  CHECK(v.track.left_m == Approx(v.body.motion_.left_m - 5000.0 - 0.05 * age_s).margin(5e-4));
}

TEST_CASE("odrive vehicle: flippers that nobody moves stay where they were let go") {
  OdriveVehicle v;
  v.run(1500);
  v.drive.flags = v.flippers.flags = 1;
  v.flippers.angle_rad[0] = 0.5;
  v.run(500);
  CHECK(v.body.flippers_.angle_rad[0] == Approx(0.5).margin(1e-6));
  v.flippers.flags = 0;
  v.flippers.angle_rad[0] = -1.0;
  v.run(50);
  v.body.flippers_.angle_rad[0] = 0.45;  // a load has pushed it down
  v.run(50);
  CHECK(v.body.flippers_.angle_rad[0] == Approx(0.5).margin(1e-6));
}

TEST_CASE("odrive vehicle: what is not finite is refused, and no number may be the robot's own") {
  OdriveVehicle v;
  rt::DriveCommand drive;
  drive.left_m_s = std::numeric_limits<double>::quiet_NaN();
  CHECK(v.runtime.set(drive, v.now) == Status::not_finite);
  rt::FlipperCommand flippers;
  flippers.angle_rad[3] = std::numeric_limits<double>::infinity();
  CHECK(v.runtime.set(flippers, v.now) == Status::not_finite);
  drivers::odrive::UgvAxesConfig config;
  for (const std::uint8_t node : {std::uint8_t{8}, std::uint8_t{9}, std::uint8_t{10}}) {
    config.track_nodes[0] = node;
    CHECK_THROWS_WITH(drivers::odrive::UgvAxes(config), Catch::Contains("robot's own frames"));
  }
  config.track_nodes[0] = 7;
  CHECK_NOTHROW(drivers::odrive::UgvAxes(config));
  config.turns_per_m = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS(drivers::odrive::UgvAxes(config));
}

TEST_CASE("odrive vehicle: what is on the bus is what its load is worked out from") {
  OdriveVehicle v;
  v.drive.flags = v.flippers.flags = 1;
  v.run(2500);
  CHECK(v.not_as_declared(drivers::odrive::bus_frames({}), 5) == "");
  // The comparison can fail: one frame less is noticed.
  auto fewer = drivers::odrive::bus_frames({});
  fewer.pop_back();
  CHECK(v.not_as_declared(fewer, 1) != "");
}
