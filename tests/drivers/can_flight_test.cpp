// SPDX-License-Identifier: BSD-3-Clause
// Frames of a UAV: fixes and commands to the rotors survive the bus, and what no device can mean is refused.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "drivers/can_codec.hpp"
#include "tests/drivers/can_codec_rig.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

rt::UavFix some_fix() {
  rt::UavFix fix;
  fix.stamp_ns = 3'000'000;
  fix.p_world_m[0] = -123.456;
  fix.p_world_m[1] = 8000.001;
  fix.p_world_m[2] = 1.5;
  fix.yaw_rad = -3.1;
  fix.flags = rt::kFixPosition | rt::kFixYaw;
  return fix;
}

}  // namespace

TEST_CASE("a fix of a UAV survives the bus to half a millimetre, late as it may be") {
  const rt::UavFix fix = some_fix();
  CanFrame frames[2];
  REQUIRE(encode_fix(fix, can_time_counter(fix.stamp_ns), frames) == Status::ok);
  CanSampleDecoder decoder;
  CanSample out;
  for (CanFrame& frame : frames) {
    frame.stamp_ns = fix.stamp_ns + 60'000'000;  // late
    REQUIRE(decoder.decode(frame, out) == Status::ok);
  }
  REQUIRE(out.kind == CanSampleKind::fix);
  CHECK(out.fix.stamp_ns == fix.stamp_ns);
  CHECK(out.fix.flags == fix.flags);
  for (int i = 0; i < 3; ++i) CHECK(std::fabs(out.fix.p_world_m[i] - fix.p_world_m[i]) <= 0.0005001);
  CHECK(std::fabs(out.fix.yaw_rad - fix.yaw_rad) <= 0.0000501);
  CHECK(decoder.decode(frames[0], out) == Status::ok);
  CHECK(decoder.decode(frames[1], out) == Status::time_repeated);
  frames[0].data[6] = frames[1].data[6] = 50;
  frames[1].data[5] = 4;  // a flag that does not exist
  CHECK(decoder.decode(frames[0], out) == Status::ok);
  CHECK(decoder.decode(frames[1], out) == Status::malformed);
  CHECK(out.kind == CanSampleKind::none);
  sortie::drivers::rig::check_balance(decoder);
}

TEST_CASE("a fix that the frames cannot say is refused") {
  CanFrame frames[2];
  rt::UavFix fix = some_fix();
  fix.p_world_m[2] = 8400;
  CHECK(encode_fix(fix, 0, frames) == Status::out_of_range);
  fix = some_fix();
  fix.yaw_rad = 4;
  CHECK(encode_fix(fix, 0, frames) == Status::out_of_range);
  fix.yaw_rad = std::numeric_limits<double>::quiet_NaN();
  CHECK(encode_fix(fix, 0, frames) == Status::not_finite);
}

TEST_CASE("what a fix does not carry is not looked at, and the bus says zero") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::uint32_t flags : {0u, +rt::kFixPosition, +rt::kFixYaw, rt::kFixPosition | rt::kFixYaw}) {
    for (const double junk : {nan, std::numeric_limits<double>::infinity(), 1e30, 7.0}) {
      CAPTURE(flags, junk);
      rt::UavFix fix = some_fix();
      fix.flags = flags;
      rt::UavFix plain = fix;
      if ((flags & rt::kFixPosition) == 0) {
        for (int i = 0; i < 3; ++i) fix.p_world_m[i] = junk;
        for (double& place : plain.p_world_m) place = 0.0;
      }
      if ((flags & rt::kFixYaw) == 0) {
        fix.yaw_rad = junk;
        plain.yaw_rad = 0.0;
      }
      CanFrame frames[2];
      CanFrame expected[2];
      REQUIRE(encode_fix(fix, 9, frames) == Status::ok);
      REQUIRE(encode_fix(plain, 9, expected) == Status::ok);
      for (int f = 0; f < 2; ++f) {
        for (int i = 0; i < 8; ++i) CHECK(frames[f].data[i] == expected[f].data[i]);
      }
    }
  }
}

TEST_CASE("speeds for eight rotors survive the bus, third by third") {
  rt::RotorCommand command;
  command.rotors = rt::kMaxRotors;
  command.flags = 1;
  for (std::uint32_t i = 0; i < rt::kMaxRotors; ++i) command.speed_rad_s[i] = 187.21 * (i + 1);
  command.speed_rad_s[7] = 1310.0;
  command.speed_rad_s[6] = 0.0;
  CanFrame frames[kCanRotorFrames];
  REQUIRE(encode_rotors(command, 200, frames) == Status::ok);
  CanSampleDecoder decoder;
  CanSample out;
  for (const CanFrame& frame : frames) {
    CanRotorThird third;
    REQUIRE(decode_rotors(frame, third) == Status::ok);
    CHECK(third.counter == 200);
    CHECK(third.enabled);
    for (std::uint32_t i = 0; i < 3 && third.first + i < rt::kMaxRotors; ++i)
      CHECK(std::fabs(third.speed_rad_s[i] - command.speed_rad_s[third.first + i]) <= 0.0100001);
    CHECK(decoder.decode(frame, out) == Status::ok);
    CHECK(out.kind == CanSampleKind::none);
  }
  CHECK(decoder.counters().rotor_frames == kCanRotorFrames);
}

TEST_CASE("a command to rotors that they cannot follow is refused, never bent") {
  CanFrame frames[kCanRotorFrames];
  rt::RotorCommand command;
  command.rotors = 6;
  command.speed_rad_s[5] = 1311.0;
  CHECK(encode_rotors(command, 0, frames) == Status::out_of_range);
  command.speed_rad_s[5] = -0.1;
  CHECK(encode_rotors(command, 0, frames) == Status::out_of_range);
  command.speed_rad_s[5] = std::numeric_limits<double>::infinity();
  CHECK(encode_rotors(command, 0, frames) == Status::not_finite);
  command.speed_rad_s[5] = 1.0;
  REQUIRE(encode_rotors(command, 0, frames) == Status::ok);
  CanRotorThird third;
  frames[0].data[7] = 2;
  CHECK(decode_rotors(frames[0], third) == Status::malformed);
  frames[1].size = 7;
  CHECK(decode_rotors(frames[1], third) == Status::malformed);
  frames[2].id = kCanDriveId;
  CHECK(decode_rotors(frames[2], third) == Status::not_supported);
}
