// SPDX-License-Identifier: BSD-3-Clause
// Flippers on the bus: commands and states there and back, incomplete and foreign frames.
#include "drivers/can_flippers.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "drivers/can_codec.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

constexpr double kStep_rad = 0.0002;

rt::FlipperSample state_at(std::int64_t stamp_ns) {
  rt::FlipperSample sample;
  sample.stamp_ns = stamp_ns;
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    sample.angle_rad[i] = 0.1 * (i + 1.0) - 0.25;
    sample.torque_n_m[i] = 3.0 - 2.0 * i;
  }
  return sample;
}

void state_frames(const rt::FlipperSample& sample, CanFrame out[rt::kFlippers]) {
  REQUIRE(encode_flipper_state(sample, can_time_counter(sample.stamp_ns), out) == Status::ok);
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) out[i].stamp_ns = sample.stamp_ns + 200'000 * (i + 1);
}

}  // namespace

TEST_CASE("a flipper command comes back within half a step, front and rear each on its own") {
  const std::uint64_t seed = 21;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  for (int i = 0; i < 5000; ++i) {
    rt::FlipperCommand command;
    command.stamp_ns = 12;
    command.flags = static_cast<std::uint32_t>(rng() & 1u);
    for (double& angle : command.angle_rad)
      angle = (static_cast<double>(rng() % 65535) - 32767.0) * kStep_rad * 0.99999;
    const auto counter = static_cast<std::uint8_t>(rng() & 0xFF);
    CanFrame frames[2];
    REQUIRE(encode_flippers(command, counter, frames) == Status::ok);
    for (std::uint32_t pair = 0; pair < 2; ++pair) {
      frames[pair].stamp_ns = 99;
      FlipperPairCommand half;
      REQUIRE(decode_flippers(frames[pair], half) == Status::ok);
      REQUIRE(half.pair == (pair == 0 ? FlipperPair::front : FlipperPair::rear));
      REQUIRE(std::fabs(half.left_rad - command.angle_rad[2 * pair]) <= 0.5 * kStep_rad * (1 + 1e-9));
      REQUIRE(std::fabs(half.right_rad - command.angle_rad[2 * pair + 1]) <= 0.5 * kStep_rad * (1 + 1e-9));
      REQUIRE(half.counter == counter);
      REQUIRE(half.flags == command.flags);
      REQUIRE(half.stamp_ns == 99);
    }
  }
}

TEST_CASE("what no flipper can mean is not put on the bus, and what is no command is not taken from it") {
  rt::FlipperCommand command;
  CanFrame frames[2];
  frames[0].id = 42;
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      command = {};
      command.angle_rad[i] = bad;
      CHECK(encode_flippers(command, 0, frames) == Status::not_finite);
    }
    command = {};
    command.angle_rad[i] = -6.56;
    CHECK(encode_flippers(command, 0, frames) == Status::out_of_range);
  }
  CHECK(frames[0].id == 42);
  command = {};
  REQUIRE(encode_flippers(command, 7, frames) == Status::ok);
  FlipperPairCommand half;
  half.counter = 200;
  CanFrame bad = frames[1];
  bad.size = 5;
  CHECK(decode_flippers(bad, half) == Status::malformed);
  bad = frames[1];
  bad.data[5] = 0x80;
  CHECK(decode_flippers(bad, half) == Status::malformed);
  bad = frames[1];
  bad.flags = kCanExtended;
  CHECK(decode_flippers(bad, half) == Status::not_supported);
  bad = frames[1];
  bad.id = kCanDriveId;
  CHECK(decode_flippers(bad, half) == Status::not_supported);
  CHECK(half.counter == 200);
}

TEST_CASE("four states of one time make a sample, in any order") {
  CanSampleDecoder decoder;
  int order[] = {0, 1, 2, 3};
  std::int64_t stamp = 0;
  do {
    stamp += 10'000'000;
    const rt::FlipperSample sample = state_at(stamp);
    CanFrame frames[rt::kFlippers];
    state_frames(sample, frames);
    CanSample out;
    for (int i = 0; i < 4; ++i) {
      REQUIRE(decoder.decode(frames[order[i]], out) == Status::ok);
      REQUIRE(out.kind == (i == 3 ? CanSampleKind::flipper : CanSampleKind::none));
    }
    REQUIRE(out.flipper.stamp_ns == stamp);
    for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
      REQUIRE(std::fabs(out.flipper.angle_rad[i] - sample.angle_rad[i]) <= 0.0001001);
      REQUIRE(std::fabs(out.flipper.torque_n_m[i] - sample.torque_n_m[i]) <= 0.005001);
    }
  } while (std::next_permutation(order, order + 4));
  CHECK(decoder.counters().flipper_samples == 24);
  CHECK(decoder.counters().frames == 96);
}

TEST_CASE("a sample with a lost, repeated or old state is not made up, and every frame is counted") {
  CanSampleDecoder decoder;
  CanSample out;
  CanFrame first[rt::kFlippers];
  CanFrame second[rt::kFlippers];
  state_frames(state_at(10'000'000), first);
  state_frames(state_at(20'000'000), second);
  for (int i = 0; i < 3; ++i) REQUIRE(decoder.decode(first[i], out) == Status::ok);
  REQUIRE(decoder.decode(first[1], out) == Status::ok);  // once more
  CHECK(decoder.pending() == 3);
  CHECK(decoder.counters().missing_partner == 1);
  for (int i = 0; i < 4; ++i) REQUIRE(decoder.decode(second[i], out) == Status::ok);
  CHECK(out.kind == CanSampleKind::flipper);
  CHECK(out.flipper.stamp_ns == 20'000'000);
  CHECK(decoder.counters().missing_partner == 4);
  for (int i = 0; i < 3; ++i) REQUIRE(decoder.decode(second[i], out) == Status::ok);
  CHECK(decoder.decode(second[3], out) == Status::time_repeated);
  for (int i = 0; i < 3; ++i) REQUIRE(decoder.decode(first[i], out) == Status::ok);
  CHECK(decoder.decode(first[3], out) == Status::time_backwards);
  CHECK(out.kind == CanSampleKind::none);
  CHECK(decoder.counters().flipper_order == 2);
  first[0].size = 8;
  CHECK(decoder.decode(first[0], out) == Status::malformed);
  second[0].stamp_ns += 5'000'000'000;
  CHECK(decoder.decode(second[0], out) == Status::stale);
  const CanDecodeCounters& c = decoder.counters();
  CHECK(c.frames == c.missing_partner + c.wrong_size + c.out_of_time +
                        4 * (c.flipper_samples + c.flipper_order) +
                        static_cast<std::uint64_t>(decoder.pending()));
  CanFrame command[2];
  REQUIRE(encode_flippers({}, 0, command) == Status::ok);
  CHECK(decoder.decode(command[0], out) == Status::ok);
  CHECK(decoder.decode(command[1], out) == Status::ok);
  CHECK(decoder.counters().flipper_frames == 2);
}

TEST_CASE("every raw angle and torque survives, and what a device cannot say is clipped") {
  for (std::int32_t raw = -32767; raw <= 32767; raw += 13) {
    rt::FlipperSample sample;
    sample.angle_rad[2] = raw * kStep_rad;
    sample.torque_n_m[2] = -raw * 0.01;
    CanFrame frames[rt::kFlippers];
    REQUIRE(encode_flipper_state(sample, 0, frames) == Status::ok);
    REQUIRE(read_can_field(frames[2], kCanFlipperStateFields[0]) == raw);
    REQUIRE(read_can_field(frames[2], kCanFlipperStateFields[1]) == -raw);
  }
  rt::FlipperSample sample;
  sample.torque_n_m[0] = 1e9;
  sample.angle_rad[0] = -1e9;
  CanFrame frames[rt::kFlippers];
  REQUIRE(encode_flipper_state(sample, 0, frames) == Status::ok);
  CHECK(read_can_field(frames[0], kCanFlipperStateFields[1]) == 32767);
  CHECK(read_can_field(frames[0], kCanFlipperStateFields[0]) == -32767);
  sample.torque_n_m[3] = std::numeric_limits<double>::quiet_NaN();
  CHECK(encode_flipper_state(sample, 0, frames) == Status::not_finite);
}
