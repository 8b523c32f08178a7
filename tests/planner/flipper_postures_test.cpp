// SPDX-License-Identifier: BSD-3-Clause
// The flippers' way from posture to posture: rate, arrival, measurements, and what does not exist.
#include "planner/flipper_postures.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

using namespace sortie;
using namespace sortie::planner;

namespace {

constexpr rt::Nanoseconds kTick_ns = 5 * rt::kNanosecondsPerMillisecond;
const FlipperPosture kPostures[] = {{{2.0, 2.0, 2.0, 2.0}}, {{0, 0, 0, 0}}, {{0.5, 0.5, -0.4, -0.4}}};

FlipperPostures usual_postures() {
  FlipperPostures flippers;
  REQUIRE(flippers.set_up(kPostures, {0.8, 0.05, 0}) == Status::ok);
  return flippers;
}

}  // namespace

TEST_CASE("Random postures are gone to at the rate, together and straight, and left alone when reached") {
  std::mt19937_64 random(31);
  FlipperPostures flippers = usual_postures();
  rt::Nanoseconds now = 0;
  for (int leg = 0; leg < 200; ++leg) {
    const auto wanted = static_cast<std::int32_t>(random() % 3);
    const FlipperOutput from = flippers.output();
    double longest = 0;
    for (std::uint32_t i = 0; i < rt::kFlippers; ++i)
      longest = std::max(longest, std::fabs(kPostures[wanted].angle_rad[i] - from.angle_rad[i]));
    const int needed = static_cast<int>(std::ceil(longest / (0.8 * 0.005) - 1e-9));
    const int steps = random() % 2 == 0 ? needed + 5 : static_cast<int>(random() % 300);
    for (int step = 1; step <= steps; ++step) {
      const FlipperOutput before = flippers.output();
      now += kTick_ns;
      REQUIRE(flippers.update(wanted, false, now) == Status::ok);
      const FlipperOutput& out = flippers.output();
      const double share = std::min(1.0, step * 0.8 * 0.005 / std::max(longest, 1e-12));
      if (leg == 0 && step == 1) continue;  // the first update has no time behind it
      for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
        REQUIRE(std::fabs(out.angle_rad[i] - before.angle_rad[i]) <= 0.8 * 0.005 * (1 + 1e-12));
        const double straight =
            from.angle_rad[i] + share * (kPostures[wanted].angle_rad[i] - from.angle_rad[i]);
        if (leg > 0) REQUIRE(out.angle_rad[i] == Approx(straight).margin(1e-9));
      }
      if (leg > 0 && step > needed) {
        REQUIRE((out.flags & kFlippersArrived) != 0);
        REQUIRE(out.angle_rad[2] == kPostures[wanted].angle_rad[2]);  // exactly
      }
      if (leg > 0 && step < needed - 1) REQUIRE((out.flags & kFlippersArrived) == 0);
    }
  }
}

TEST_CASE("Told to hold they stand still, and then go on, -1 keeps what was asked for") {
  FlipperPostures flippers = usual_postures();
  REQUIRE(flippers.update(1, false, kTick_ns) == Status::ok);
  for (int i = 2; i < 100; ++i) REQUIRE(flippers.update(-1, false, i * kTick_ns) == Status::ok);
  const double angle = flippers.output().angle_rad[0];
  CHECK(angle == Approx(2.0 - 98 * 0.004));
  for (int i = 100; i < 200; ++i) REQUIRE(flippers.update(-1, true, i * kTick_ns) == Status::ok);
  CHECK(flippers.output().angle_rad[0] == angle);
  CHECK((flippers.output().flags & kFlippersHeld) != 0);
  for (int i = 200; i < 1000; ++i) REQUIRE(flippers.update(-1, false, i * kTick_ns) == Status::ok);
  CHECK(flippers.output().angle_rad[0] == 0.0);
  CHECK(flippers.output().posture == 1);
}

TEST_CASE("After a pause they go on as if it had been a fifth of a second, and do not jump") {
  for (const rt::Nanoseconds pause : {100 * rt::kNanosecondsPerMillisecond, 10 * rt::kNanosecondsPerSecond}) {
    FlipperPostures flippers = usual_postures();
    REQUIRE(flippers.update(1, false, kTick_ns) == Status::ok);
    REQUIRE(flippers.update(1, false, kTick_ns + pause) == Status::ok);
    CHECK(flippers.output().angle_rad[0] == Approx(2.0 - 0.8 * std::min(0.2, rt::to_seconds(pause))));
  }
}

TEST_CASE("They start from where they say they are, and are there when the measurement says so") {
  FlipperPostures flippers = usual_postures();
  rt::FlipperSample sample;
  for (double& angle : sample.angle_rad) angle = 1.9;
  sample.angle_rad[3] = std::numeric_limits<double>::quiet_NaN();
  CHECK(flippers.observe(sample) == Status::not_finite);
  CHECK(flippers.output().angle_rad[0] == 2.0);
  sample.angle_rad[3] = 1.9;
  REQUIRE(flippers.observe(sample) == Status::ok);
  CHECK(flippers.output().angle_rad[0] == 1.9);
  for (int i = 1; i < 200; ++i) REQUIRE(flippers.update(0, false, i * kTick_ns) == Status::ok);
  CHECK((flippers.output().flags & kFlippersArrived) != 0);
  CHECK((flippers.output().flags & kFlippersThere) == 0);  // 0.1 rad away
  for (double& angle : sample.angle_rad) angle = 1.96;
  REQUIRE(flippers.observe(sample) == Status::ok);
  CHECK(flippers.output().angle_rad[0] == 2.0);  // the command does not follow any more
  REQUIRE(flippers.update(0, false, 200 * kTick_ns) == Status::ok);
  CHECK((flippers.output().flags & kFlippersThere) != 0);
}

TEST_CASE("Postures that do not exist, bad set-ups and bad times are refused") {
  FlipperPostures flippers = usual_postures();
  REQUIRE(flippers.update(1, false, kTick_ns) == Status::ok);
  CHECK(flippers.update(3, false, 2 * kTick_ns) == Status::out_of_range);
  CHECK(flippers.update(-2, false, 3 * kTick_ns) == Status::out_of_range);
  CHECK(flippers.output().posture == 1);
  CHECK(flippers.output().refused == 2);
  CHECK(flippers.update(1, false, 3 * kTick_ns) == Status::time_repeated);
  CHECK(flippers.update(1, false, kTick_ns) == Status::time_backwards);
  FlipperPostures other;
  CHECK(other.set_up({}, {}) == Status::empty);
  CHECK(other.set_up(std::vector<FlipperPosture>(17), {}) == Status::full);
  CHECK(other.set_up(kPostures, {0.8, 0.05, 3}) == Status::out_of_range);
  CHECK(other.set_up(kPostures, {0.0, 0.05, 0}) == Status::out_of_range);
  const FlipperPosture bad[] = {{{0, std::numeric_limits<double>::infinity(), 0, 0}}};
  CHECK(other.set_up(bad, {}) == Status::not_finite);
}

TEST_CASE("A state with a posture that these flippers do not have is refused") {
  FlipperPostures flippers = usual_postures(), others;
  REQUIRE(flippers.update(2, false, kTick_ns) == Status::ok);
  rt::Archive measure = rt::Archive::measuring();
  flippers.archive(measure);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  flippers.archive(write);
  REQUIRE(others.set_up(std::span{kPostures}.first(2), {0.8, 0.05, 0}) == Status::ok);
  rt::Archive read = rt::Archive::reading(bytes);
  others.archive(read);
  CHECK(read.status() == Status::malformed);
  CHECK(others.update(-1, false, 2 * kTick_ns) == Status::ok);
}
