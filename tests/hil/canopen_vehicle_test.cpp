// SPDX-License-Identifier: BSD-3-Clause
// The robot's drives on CANopen at both ends: what the runtime's side reads is what the body did.
#include <catch2/catch.hpp>
#include <limits>

#include "drivers/canopen/ugv_nodes.hpp"
#include "hil/canopen/vehicle_drives.hpp"
#include "tests/hil/motors_vehicle.hpp"

using namespace sortie;

using CanopenVehicle = hil::test::MotorsVehicle<drivers::canopen::UgvNodes, drivers::canopen::UgvNodesConfig,
                                                hil::VehicleDrives, hil::VehicleDrivesConfig>;

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
  CHECK(v.runtime.running());
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
  CHECK(v.runtime.running());
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

TEST_CASE("canopen vehicle: what is on the bus is what its load is worked out from") {
  CanopenVehicle v;
  v.drive.flags = v.flippers.flags = 1;
  v.run(2000);
  CHECK(v.not_as_declared(drivers::canopen::bus_frames({}), 5) == "");
  // The comparison can fail: one frame less is noticed.
  auto fewer = drivers::canopen::bus_frames({});
  fewer.pop_back();
  CHECK(v.not_as_declared(fewer, 1) != "");
}
