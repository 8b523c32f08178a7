// SPDX-License-Identifier: BSD-3-Clause
// located_t against lcm-gen's code: same bytes, every bit back, nothing taken that is damaged.
#include "drivers/wire.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "sortie/located_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

// Every scalar its own bits, so that two that change places are seen.
rt::LocatedPose any_located(std::mt19937_64& random) {
  std::uint8_t canonical[rt::canonical_size<rt::LocatedPose>()];
  for (std::uint8_t& byte : canonical) byte = static_cast<std::uint8_t>(random());
  rt::LocatedPose pose;
  rt::decode_canonical(canonical, pose);
  pose.weak_moves = static_cast<std::uint32_t>(random() % 4);
  pose.weak_turns = static_cast<std::uint32_t>(random() % 4);
  return pose;
}

located_t twin_of(const rt::LocatedPose& pose, std::int64_t seq) {
  located_t twin{};
  twin.stamp_ns = pose.stamp_ns;
  twin.seq = seq;
  twin.verdict = static_cast<std::int8_t>(pose.verdict);
  std::memcpy(twin.p_map_odom_m, pose.p_map_odom_m, sizeof twin.p_map_odom_m);
  std::memcpy(twin.q_map_odom, pose.q_map_odom, sizeof twin.q_map_odom);
  std::memcpy(twin.p_map_body_m, pose.p_map_body_m, sizeof twin.p_map_body_m);
  std::memcpy(twin.q_map_body, pose.q_map_body, sizeof twin.q_map_body);
  std::memcpy(twin.p_map_sensor_m, pose.p_map_sensor_m, sizeof twin.p_map_sensor_m);
  std::memcpy(twin.q_map_sensor, pose.q_map_sensor, sizeof twin.q_map_sensor);
  std::memcpy(twin.covariance, pose.covariance, sizeof twin.covariance);
  twin.share = pose.share;
  twin.known = pose.known;
  twin.crossed = pose.crossed;
  twin.returns = static_cast<std::int32_t>(pose.returns);
  twin.steps = static_cast<std::int32_t>(pose.steps);
  twin.weak_moves = static_cast<std::int32_t>(pose.weak_moves);
  twin.weak_turns = static_cast<std::int32_t>(pose.weak_turns);
  std::memcpy(twin.weak_move_map, pose.weak_move_map, sizeof twin.weak_move_map);
  std::memcpy(twin.weak_move_sigma_m, pose.weak_move_sigma_m, sizeof twin.weak_move_sigma_m);
  std::memcpy(twin.weak_turn_map, pose.weak_turn_map, sizeof twin.weak_turn_map);
  std::memcpy(twin.weak_turn_sigma_rad, pose.weak_turn_sigma_rad, sizeof twin.weak_turn_sigma_rad);
  twin.scans = static_cast<std::int64_t>(pose.scans);
  twin.placed = static_cast<std::int64_t>(pose.placed);
  return twin;
}

test::Bytes located_bytes(const rt::LocatedPose& pose, std::int64_t seq) {
  return test::exact([&](auto out, auto& size) { return encode(pose, seq, out, size); });
}

}  // namespace

TEST_CASE("a located pose is written as lcm-gen writes it and comes back bit for bit") {
  std::mt19937_64 random(21);
  for (std::int64_t round = 0; round < 50; ++round) {
    INFO("seed 21, round " << round);
    const rt::LocatedPose pose = any_located(random);
    const test::Bytes bytes = located_bytes(pose, round);
    REQUIRE(bytes.size() == kLocatedBytes);
    REQUIRE((bytes == test::generated_bytes(twin_of(pose, round))));
    rt::LocatedPose back;
    std::int64_t seq = -1;
    REQUIRE(decode(bytes, back, seq) == Status::ok);
    REQUIRE(seq == round);
    REQUIRE((located_bytes(back, seq) == bytes));
    test::Bytes cut = bytes;
    cut.pop_back();
    REQUIRE(decode(cut, back, seq) == Status::malformed);
  }
}

TEST_CASE("a located pose with more weak directions than space has is not taken, and changes nothing") {
  rt::LocatedPose pose;
  pose.weak_turns = 4;
  rt::LocatedPose back;
  back.scans = 7;
  std::int64_t seq = 5;
  CHECK(decode(located_bytes(pose, 1), back, seq) == Status::malformed);
  CHECK(back.scans == 7);
  CHECK(seq == 5);
  pose.weak_turns = 3;
  CHECK(decode(located_bytes(pose, 1), back, seq) == Status::ok);
  CHECK(seq == 1);
}
