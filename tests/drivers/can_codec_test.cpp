// SPDX-License-Identifier: BSD-3-Clause
// The codec of the robot's frames: there and back, wrapping counters, time that goes on.
#include "drivers/can_codec.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <random>

#include "rt/fields.hpp"
#include "tests/drivers/can_codec_rig.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::drivers::rig;

TEST_CASE("an IMU sample comes back within half a step, whichever half comes first") {
  const std::uint64_t seed = 11;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  CanSampleDecoder decoder;
  std::int64_t stamp = 0;
  for (int i = 0; i < 5000; ++i) {
    stamp += static_cast<std::int64_t>(1 + rng() % 300) * kCanCounterStepNs;
    rt::ImuSample sample = imu_at(stamp);
    for (int k = 0; k < 3; ++k) {
      sample.gyr_rad_s[k] = (static_cast<double>(rng() % 20001) - 10000.0) * 1.6e-3;
      sample.acc_m_s2[k] = (static_cast<double>(rng() % 20001) - 10000.0) * 1.6e-2;
    }
    CanFrame frames[2];
    imu_frames(sample, frames);
    if (i % 2 == 1) std::swap(frames[0].stamp_ns, frames[1].stamp_ns);
    CanSample out;
    REQUIRE(decoder.decode(frames[i % 2], out) == Status::ok);
    REQUIRE(out.kind == CanSampleKind::none);
    REQUIRE(decoder.decode(frames[1 - i % 2], out) == Status::ok);
    REQUIRE(out.kind == CanSampleKind::imu);
    REQUIRE(out.imu.stamp_ns == stamp);
    REQUIRE(out.imu.flags == (rt::kImuGyr | rt::kImuAcc));
    for (int k = 0; k < 3; ++k) {
      REQUIRE(std::fabs(out.imu.gyr_rad_s[k] - sample.gyr_rad_s[k]) <= 0.00025 * (1 + 1e-9));
      REQUIRE(std::fabs(out.imu.acc_m_s2[k] - sample.acc_m_s2[k]) <= 0.0025 * (1 + 1e-9));
    }
  }
  CHECK(decoder.counters().imu_samples == 5000);
  check_balance(decoder);
}

TEST_CASE("every raw value survives decoding and encoding unchanged") {
  for (std::int32_t raw = -32767; raw <= 32767; ++raw) {
    CanFrame frames[2];
    rt::ImuSample sample = imu_at(1'000'000);
    REQUIRE(encode_imu(sample, can_time_counter(sample.stamp_ns), frames) == Status::ok);
    for (int i = 0; i < 2; ++i) {
      write_can_field(frames[i], kCanImuGyrFields[1], raw);
      frames[i].stamp_ns = 1'000'000;
    }
    CanSampleDecoder decoder;
    CanSample out;
    REQUIRE(decoder.decode(frames[0], out) == Status::ok);
    REQUIRE(decoder.decode(frames[1], out) == Status::ok);
    CanFrame again[2];
    REQUIRE(encode_imu(out.imu, can_time_counter(out.imu.stamp_ns), again) == Status::ok);
    for (int i = 0; i < 2; ++i) REQUIRE(std::equal(again[i].data, again[i].data + 8, frames[i].data));
  }
}

TEST_CASE("stamps stay right while the time counter wraps, and over gaps of any length") {
  CanSampleDecoder decoder;
  std::int64_t stamp = 0;
  for (const std::int64_t gap : {std::int64_t{1'000'000}, std::int64_t{6'553'500'000}, std::int64_t{100'000},
                                 std::int64_t{6'553'600'000}, std::int64_t{3'600'000'000'000},
                                 std::int64_t{1'700'000'000'000'000'000}}) {
    stamp += gap;
    CanFrame frames[2];
    imu_frames(imu_at(stamp), frames, 999'000'000 - 250'000);
    CanSample out;
    REQUIRE(decoder.decode(frames[0], out) == Status::ok);
    REQUIRE(decoder.decode(frames[1], out) == Status::ok);
    REQUIRE(out.kind == CanSampleKind::imu);
    CHECK(out.imu.stamp_ns == stamp);
  }
  CHECK(decoder.counters().imu_samples == 6);
}

TEST_CASE("the time counter is unwrapped as a search through all times would find it") {
  const std::uint64_t seed = 3;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  const std::int64_t epoch = -12'345'678;
  const CanCounterClock clock(epoch, 1'000'000'000, 1'000'000);
  for (int i = 0; i < 4000; ++i) {
    const auto bus = static_cast<std::int64_t>(rng() % 40'000'000'000) - 20'000'000'000;
    auto counter = static_cast<std::uint16_t>(rng() & 0xFFFF);
    if (i % 2 == 0) {  // the edges of what is believable
      const std::int64_t edges[] = {11, 10, 9, 0, -1, -9'999, -10'000, -10'001};
      const auto steps = static_cast<std::int64_t>(std::floor(static_cast<double>(bus - epoch) / 1e5));
      counter = static_cast<std::uint16_t>((steps + edges[rng() % 8]) & 0xFFFF);
    }
    // Twin: walk back step by step from the youngest time allowed.
    bool found = false;
    std::int64_t expected = 0;
    const std::int64_t now = static_cast<std::int64_t>(std::floor(static_cast<double>(bus - epoch) / 1e5));
    for (std::int64_t step = now + 10; step >= now - 10'000 && !found; --step) {
      if (((step % 65536) + 65536) % 65536 != counter) continue;
      found = true;
      expected = epoch + step * 100'000;
    }
    std::int64_t stamp = 0;
    const Status status = clock.unwrap(counter, bus, stamp);
    REQUIRE((status == Status::ok) == found);
    if (found) REQUIRE(stamp == expected);
    if (found) REQUIRE(clock.counter(stamp) == counter);
  }
}

TEST_CASE("track travel goes on past the wrap of the 32-bit count, both ways") {
  const double wrap_m = 2147483648.0 * kCanTrackMetresPerCount;
  CanSampleDecoder decoder;
  CanSample out;
  CanFrame frames[2];
  for (int i = 0; i < 400; ++i) {
    const std::int64_t stamp = i * 10'000'000LL;
    const double left = wrap_m - 1.0 + 0.01 * i;
    const double right = -wrap_m + 1.0 - 0.01 * i;
    track_frames(stamp, left, right, frames);
    REQUIRE(decoder.decode(frames[0], out) == Status::ok);
    REQUIRE(decoder.decode(frames[1], out) == Status::ok);
    REQUIRE(out.kind == CanSampleKind::track);
    REQUIRE(out.track.stamp_ns == stamp);
    REQUIRE(out.track.left_m == Approx(left).margin(0.6 * kCanTrackMetresPerCount));
    REQUIRE(out.track.right_m == Approx(right).margin(0.6 * kCanTrackMetresPerCount));
  }
  rt::TrackSample far;
  far.left_m = 1e15;
  CHECK(encode_track(far, 0, frames) == Status::out_of_range);
}

TEST_CASE("an encoder that jumps is refused once, a restarted one goes on without the jump") {
  CanSampleDecoder decoder;
  CanSample out;
  CanFrame frames[2];
  const auto step = [&](std::int64_t ms, double left, double right) {
    track_frames(ms * 1'000'000, left, right, frames);
    REQUIRE(decoder.decode(frames[0], out) == Status::ok);
    return decoder.decode(frames[1], out);
  };
  REQUIRE(step(0, 100.0, 100.0) == Status::ok);
  REQUIRE(step(10, 100.01, 100.01) == Status::ok);
  CHECK(step(20, 100.02, 7000.0) == Status::out_of_range);  // one wild value
  CHECK(out.kind == CanSampleKind::none);
  REQUIRE(step(30, 100.03, 100.03) == Status::ok);  // nothing was lost by it
  CHECK(out.track.right_m == Approx(100.03));
  CHECK(step(40, 100.04, 0.0) == Status::out_of_range);  // the right encoder starts again
  REQUIRE(step(50, 100.05, 0.01) == Status::ok);
  CHECK(out.track.left_m == Approx(100.05));
  CHECK(out.track.right_m == Approx(100.04));  // the travel while it was dead is all that is missing
  CHECK(decoder.counters().encoder_jumps == 2);
  REQUIRE(step(60'000, 1000.0, 900.0) == Status::ok);  // a long silence makes a long way believable
  CHECK(out.track.left_m == Approx(1000.0));
  constexpr std::int64_t kSeventyYearsMs = 2'209'000'000'000;
  REQUIRE(step(kSeventyYearsMs, 200'000.0, 900.0) == Status::ok);
  check_balance(decoder);
}

TEST_CASE(
    "the frame table is sound: fields fit, do not overlap, identifiers rise and keep clear of CANopen") {
  std::uint32_t last = 0x100;
  for (const CanMessage& spec : kCanFrames) {
    INFO(spec.name);
    CHECK(spec.id > last);
    CHECK(spec.id <= 0x180);
    last = spec.id;
    std::uint32_t used = 0;
    for (std::size_t i = 0; i < spec.field_count; ++i) {
      const CanSignal& field = spec.fields[i];
      REQUIRE(field.shift % 8 == 0);
      REQUIRE(field.length % 8 == 0);
      CHECK_FALSE(field.big_endian);
      for (unsigned b = 0; b < field.length / 8u; ++b) {
        const unsigned byte = field.shift / 8u + b;
        REQUIRE(byte < spec.size);
        CHECK((used & (1u << byte)) == 0);
        used |= 1u << byte;
      }
    }
    CHECK(used == (1u << spec.size) - 1u);
  }
}
