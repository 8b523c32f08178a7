// SPDX-License-Identifier: BSD-3-Clause
// Every reason for which the codec of the robot's frames refuses, and that each frame is accounted for.
#include "drivers/can_codec.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <random>

#include "rt/fields.hpp"
#include "tests/drivers/can_codec_rig.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::drivers::rig;

TEST_CASE("a counter that does not fit the bus stamp is refused as stale") {
  CanSampleDecoder decoder;
  CanFrame frames[2];
  CanSample out;
  imu_frames(imu_at(10'000'000'000), frames, 1'100'000'000);
  CHECK(decoder.decode(frames[0], out) == Status::stale);
  imu_frames(imu_at(10'000'000'000), frames, -1'000'000);
  CHECK(decoder.decode(frames[0], out) == Status::ok);
  imu_frames(imu_at(10'000'000'000), frames, -1'100'000);
  CHECK(decoder.decode(frames[0], out) == Status::stale);
  frames[0].stamp_ns = std::numeric_limits<std::int64_t>::min();
  CHECK(decoder.decode(frames[0], out) == Status::out_of_range);
  CHECK(decoder.counters().out_of_time == 3);
  check_balance(decoder);
}

TEST_CASE("a half without its partner is counted, and the next sample is whole") {
  CanSampleDecoder decoder;
  CanFrame first[2];
  CanFrame second[2];
  imu_frames(imu_at(1'000'000), first);
  imu_frames(imu_at(2'000'000), second);
  CanSample out;
  REQUIRE(decoder.decode(first[0], out) == Status::ok);  // its acc is lost
  REQUIRE(decoder.decode(second[0], out) == Status::ok);
  CHECK(decoder.counters().missing_partner == 1);
  REQUIRE(decoder.decode(second[1], out) == Status::ok);
  CHECK(out.kind == CanSampleKind::imu);
  CHECK(out.imu.stamp_ns == 2'000'000);

  imu_frames(imu_at(3'000'000), first);  // its gyr is lost
  imu_frames(imu_at(4'000'000), second);
  REQUIRE(decoder.decode(first[1], out) == Status::ok);
  REQUIRE(decoder.decode(second[0], out) == Status::ok);
  REQUIRE(decoder.decode(second[1], out) == Status::ok);
  CHECK(out.kind == CanSampleKind::imu);
  CHECK(decoder.counters().missing_partner == 2);

  // Halves one wrap of the counter apart look alike and are no partners.
  imu_frames(imu_at(10'000'000'000), first);
  imu_frames(imu_at(10'000'000'000 + 6'553'600'000), second);
  REQUIRE(decoder.decode(first[0], out) == Status::ok);
  REQUIRE(decoder.decode(second[1], out) == Status::ok);
  CHECK(out.kind == CanSampleKind::none);
  CHECK(decoder.counters().missing_partner == 3);
  check_balance(decoder);
}

TEST_CASE("repeated and older samples are refused by name") {
  CanSampleDecoder decoder;
  CanFrame frames[2];
  CanSample out;
  imu_frames(imu_at(2'000'000), frames);
  REQUIRE(decoder.decode(frames[0], out) == Status::ok);
  REQUIRE(decoder.decode(frames[1], out) == Status::ok);
  REQUIRE(decoder.decode(frames[0], out) == Status::ok);
  CHECK(decoder.decode(frames[1], out) == Status::time_repeated);
  CHECK(out.kind == CanSampleKind::none);
  imu_frames(imu_at(1'900'000), frames);
  REQUIRE(decoder.decode(frames[0], out) == Status::ok);
  CHECK(decoder.decode(frames[1], out) == Status::time_backwards);
  CHECK(decoder.counters().time_repeated == 1);
  CHECK(decoder.counters().time_backwards == 1);
  check_balance(decoder);
}

TEST_CASE("a clipped axis marks the sample, from the encoder and from raw bytes alike") {
  for (const std::int64_t raw : {32767, -32767, -32768, 32766, -32766}) {
    CanFrame frames[2];
    imu_frames(imu_at(1'000'000), frames);
    write_can_field(frames[1], kCanImuAccFields[2], raw);
    CanSampleDecoder decoder;
    CanSample out;
    REQUIRE(decoder.decode(frames[0], out) == Status::ok);
    REQUIRE(decoder.decode(frames[1], out) == Status::ok);
    const bool clipped = raw > 32766 || raw < -32766;
    CHECK(((out.imu.flags & rt::kImuSaturated) != 0) == clipped);
    CHECK(((out.imu.flags & rt::kImuOnlyAccSaturated) != 0) == clipped);
    CHECK(decoder.counters().saturated == (clipped ? 1 : 0));
  }
  for (const double rate : {20.0, -1e300, 16.3835}) {
    rt::ImuSample sample = imu_at(1'000'000);
    sample.gyr_rad_s[0] = rate;
    CanFrame frames[2];
    imu_frames(sample, frames);
    CHECK(std::abs(read_can_field(frames[0], kCanImuGyrFields[0])) == 32767);
  }
}

TEST_CASE("values that are not finite are never put on the bus") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  CanFrame frames[2];
  frames[0].id = 42;
  for (const double bad : {nan, inf, -inf}) {
    for (int axis = 0; axis < 6; ++axis) {
      rt::ImuSample sample = imu_at(0);
      (axis < 3 ? sample.gyr_rad_s[axis] : sample.acc_m_s2[axis - 3]) = bad;
      CHECK(encode_imu(sample, 0, frames) == Status::not_finite);
    }
    rt::TrackSample track;
    track.right_m = bad;
    CHECK(encode_track(track, 0, frames) == Status::not_finite);
    rt::DriveCommand command;
    command.left_m_s = bad;
    CHECK(encode_drive(command, 0, frames[0]) == Status::not_finite);
  }
  CHECK(frames[0].id == 42);
}

TEST_CASE("a drive command comes back, and what is not one is refused") {
  rt::DriveCommand command;
  command.stamp_ns = 5;
  command.left_m_s = -1.2344;
  command.right_m_s = 32.767;
  command.flags = 1;
  CanFrame frame;
  REQUIRE(encode_drive(command, 200, frame) == Status::ok);
  CHECK(frame.id == 0x110);
  CHECK(frame.size == 6);
  frame.stamp_ns = 777;
  rt::DriveCommand back;
  std::uint8_t counter = 0;
  REQUIRE(decode_drive(frame, back, counter) == Status::ok);
  CHECK(back.stamp_ns == 777);
  CHECK(back.left_m_s == Approx(-1.234));
  CHECK(back.right_m_s == Approx(32.767));
  CHECK(back.flags == 1);
  CHECK(counter == 200);

  command.flags = 0;  // not enabled, whatever the speeds say
  CanFrame idle;
  REQUIRE(encode_drive(command, 201, idle) == Status::ok);
  REQUIRE(decode_drive(idle, back, counter) == Status::ok);
  CHECK(back.flags == 0);
  REQUIRE(decode_drive(frame, back, counter) == Status::ok);

  command.left_m_s = 32.768;
  CHECK(encode_drive(command, 0, frame) == Status::out_of_range);
  command.left_m_s = 0;
  command.right_m_s = -32.768;
  CHECK(encode_drive(command, 0, frame) == Status::out_of_range);
  CanFrame bad = frame;
  bad.size = 5;
  CHECK(decode_drive(bad, back, counter) == Status::malformed);
  bad = frame;
  bad.data[5] = 2;
  CHECK(decode_drive(bad, back, counter) == Status::malformed);
  bad = frame;
  bad.id = 0x111;
  CHECK(decode_drive(bad, back, counter) == Status::not_supported);
  bad = frame;
  bad.flags = kCanRemote;
  CHECK(decode_drive(bad, back, counter) == Status::not_supported);
  CHECK(counter == 200);
}

TEST_CASE("each kind of foreign or broken frame has its counter") {
  CanSampleDecoder decoder;
  CanSample out;
  CanFrame f;
  f.id = 0x123;
  CHECK(decoder.decode(f, out) == Status::not_supported);
  f.id = kCanImuGyrId;
  f.flags = kCanExtended;
  CHECK(decoder.decode(f, out) == Status::not_supported);
  CHECK(decoder.counters().unknown_id == 2);
  f.flags = kCanRemote;
  CHECK(decoder.decode(f, out) == Status::not_supported);
  CHECK(decoder.counters().remote_frames == 1);
  f.flags = kCanError;
  CHECK(decoder.decode(f, out) == Status::not_supported);
  CHECK(decoder.counters().error_frames == 1);
  f.flags = 0;
  f.size = 7;
  CHECK(decoder.decode(f, out) == Status::malformed);
  f.size = 255;
  CHECK(decoder.decode(f, out) == Status::malformed);
  f.size = 8;
  f.flags = 0x80;
  CHECK(decoder.decode(f, out) == Status::malformed);
  CHECK(decoder.counters().wrong_size == 3);
  f.flags = 0;
  f.id = kCanDriveId;
  f.size = 6;
  CHECK(decoder.decode(f, out) == Status::ok);
  CHECK(decoder.counters().drive_frames == 1);
  check_balance(decoder);
}

TEST_CASE("random frames never break the decoder, and every one of them is accounted for") {
  const std::uint64_t seed = 424242;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  CanSampleDecoder decoder;
  std::int64_t now = 0;
  std::int64_t last_imu = std::numeric_limits<std::int64_t>::min();
  int burst = 0;           // states of all flippers one after the other, as a device sends them
  std::size_t halves = 0;  // of IMU, fixes and tracks, of which two must meet
  while (kCanFrames[halves].id != kCanImuGyrId) ++halves;
  for (int i = 0; i < 1'000'000; ++i) {
    CanFrame f;
    if (burst == 0) now += static_cast<std::int64_t>(rng() % 200'000);
    if (burst == 0 && rng() % 64 == 0) burst = 4;
    f.stamp_ns = rng() % 1000 == 0 ? static_cast<std::int64_t>(rng()) : now;
    std::size_t half = rng() % 4;
    if (half >= 2) half += 2;
    if (rng() % 8 == 0) half = 2 + rng() % 2;
    const auto pick =
        static_cast<std::size_t>(rng() % 8 == 0 ? rng() % std::size(kCanFrames) : halves + half);
    f.id = rng() % 8 == 0 ? static_cast<std::uint32_t>(rng()) : kCanFrames[pick].id;
    f.size = static_cast<std::uint8_t>(rng() % 8 == 0         ? rng() & 0xFF
                                       : find_can_frame(f.id) ? find_can_frame(f.id)->size
                                                              : 8);
    f.flags = static_cast<std::uint8_t>(rng() % 16 == 0 ? rng() & 0xFF : 0);
    for (auto& byte : f.data) byte = static_cast<std::uint8_t>(rng() & 0xFF);
    if (rng() % 16 == 0) f.data[0] = 0xFF, f.data[1] = 0x7F;  // a clipped axis
    if (rng() % 4 != 0) {  // a believable time, so that the later checks are reached, too
      const std::uint64_t age = rng() % 16 == 0 ? rng() % 30 : rng() % 3;
      const std::uint16_t counter = can_time_counter(now - static_cast<std::int64_t>(age) * 100'000);
      const CanMessage* spec = find_can_frame(f.id);
      if (spec != nullptr && std::string_view(spec->fields[spec->field_count - 1].name) == "time")
        write_can_field(f, spec->fields[spec->field_count - 1], counter);
    }
    if (f.id == kCanFixUpId && rng() % 4 != 0) f.data[5] &= 3;  // flags that there are
    if (burst > 0) {
      f = {};
      f.stamp_ns = now;
      f.id = kCanFlipperStateId + static_cast<std::uint32_t>(--burst);
      f.size = 6;
      write_can_field(f, kCanFlipperStateFields[2], can_time_counter(now));
    }
    CanSample out;
    const Status status = decoder.decode(f, out);
    if (status != Status::ok) REQUIRE(out.kind == CanSampleKind::none);
    if (out.kind == CanSampleKind::imu) {
      REQUIRE(out.imu.stamp_ns > last_imu);
      last_imu = out.imu.stamp_ns;
      for (int k = 0; k < 3; ++k) REQUIRE(std::fabs(out.imu.gyr_rad_s[k]) <= 16.384);
    }
  }
  check_balance(decoder);
  rt::for_each_scalar(decoder.counters(), [](const char* name, int, std::uint64_t count) {
    INFO(name);
    CHECK(count > 0);
  });
}

TEST_CASE("a codec that cannot work is refused with its cure") {
  CanCodecConfig config;
  config.max_age_ns = 7'000'000'000;
  CHECK_THROWS_WITH(CanSampleDecoder(config), Catch::Contains("max_age_ns"));
  config = {};
  config.max_track_m_s = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(CanSampleDecoder(config), Catch::Contains("max_track_m_s"));
}
