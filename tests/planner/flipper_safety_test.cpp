// SPDX-License-Identifier: BSD-3-Clause
// The flippers' policy where it must not go, and the ways out.
#include "planner/flipper_policy.hpp"

#include <catch2/catch.hpp>

#include "tests/planner/flipper_rig.hpp"

namespace sortie::planner {
namespace {
constexpr rt::Nanoseconds kSafetyJob_ns = 50 * rt::kNanosecondsPerMillisecond;
constexpr double kLevel_m = 0.07192;

/// Asks from `first` on, 20 times a second, until a verdict is another one; the number of times it was said.
int said_in_a_row(FlipperPolicy& policy, const HeightView& view, FlipperInput in, FlipperVerdict verdict,
                  rt::Nanoseconds& now_ns, FlipperDecision& decision) {
  for (int k = 0;; ++k) {
    now_ns += kSafetyJob_ns;
    in.stamp_ns = in.map_ns = in.attitude_ns = in.flippers_ns = now_ns;
    REQUIRE(policy.decide(view, in, decision) == Status::ok);
    if (decision.verdict != verdict || k > 1000) return k;
  }
}
}  // namespace

TEST_CASE("flippers: a cliff at the nose is never driven at", "[planner][flippers]") {
  constexpr std::uint64_t kSeed = 41;
  INFO("seed " << kSeed);
  int stopped = 0;
  for (int k = 0; k < 40; ++k) {
    hil::Random random(kSeed + static_cast<std::uint64_t>(k), 0x636c6966);
    const double yaw = random.uniform(-3.1, 3.1), edge = random.uniform(0.05, 0.34);
    const double depth = random.uniform(0.6, 3.0), skew = random.uniform(-0.3, 0.3);
    const CellGround cliff = CellGround::of([=](double x, double y) {
      const double ahead = x * std::cos(yaw) + y * std::sin(yaw),
                   left = y * std::cos(yaw) - x * std::sin(yaw);
      return ahead + std::tan(skew) * left > edge ? -depth : 0.0;
    });
    const auto policy = flipper_policy();
    FlipperInput in = flipper_input(kSafetyJob_ns, {0.0, 0.0, yaw}, kLevel_m);
    FlipperDecision d;
    REQUIRE(policy->decide(cliff.view(), in, d) == Status::ok);
    INFO("edge " << edge << " m ahead, " << depth << " m deep, skew " << skew);
    CHECK(!moves(d));
    CHECK(d.probability > 0.0);
    if (d.verdict == FlipperVerdict::stop && d.reason == FlipperReason::unsafe_ground) ++stopped;
  }
  CHECK(stopped == 40);  // nothing is missing: no way out is tried
}

TEST_CASE("flippers: where nothing is known it never goes", "[planner][flippers][heavy]") {
  constexpr std::uint64_t kSeed = 7001;
  INFO("seed " << kSeed);
  const CellGround unknown;
  CellGround hung;  // rays passed over it, high above
  for (HeightCell& cell : hung.cells) cell = {0.0, 0.3, HeightState::bounded_above};
  const auto policy = flipper_policy();
  hil::Random random(kSeed, 0x756e6b6e);
  rt::Nanoseconds now = 0;
  int went = 0;
  FlipperInput in;
  for (int k = 0; k < 3000; ++k) {
    now += kSafetyJob_ns;
    // Now and then long enough for every way out.
    if (k % 50 == 0) {
      in = flipper_input(now, {random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-3, 3)}, 0.1);
      in.arc = {random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)};
      for (double& angle : in.measured_rad) angle = random.uniform(-0.5, 1.3);
      in.pitch_rad = random.uniform(-0.3, 0.3);
      in.roll_rad = random.uniform(-0.3, 0.3);
    }
    now += random.uniform(0, 1) < 0.2 ? rt::kNanosecondsPerSecond : 0;
    in.stamp_ns = in.map_ns = in.attitude_ns = in.flippers_ns = now;
    in.looked = random.uniform(0, 1) < 0.1;
    FlipperDecision d;
    REQUIRE(policy->decide((k / 50 % 2 == 0 ? unknown : hung).view(), in, d) == Status::ok);
    if (moves(d)) ++went;
  }
  CHECK(went == 0);
  CHECK(policy->counters().looked > 20);
  CHECK(policy->counters().stopped > 20);
}

TEST_CASE("flippers: missing ground is looked at, felt, crept up to, and then it stops",
          "[planner][flippers]") {
  // Known up to 0.65 m ahead, a little beyond the flippers; what is more than 0.3 m farther has no bounds.
  CellGround ground = CellGround::of([](double, double) { return 0.0; });
  for (int j = -CellGround::kHalf; j < CellGround::kHalf; ++j)
    for (int i = 13; i < CellGround::kHalf; ++i) ground.at(i, j) = {};
  const auto policy = flipper_policy();
  FlipperInput in = flipper_input(0, {0.0, 0.0, 0.0}, kLevel_m);
  rt::Nanoseconds now = 0;
  FlipperDecision d;
  const int looks = said_in_a_row(*policy, ground.view(), in, FlipperVerdict::look, now, d);
  CHECK(looks == 41);  // 2 s
  CHECK(d.verdict == FlipperVerdict::feel);
  CHECK(d.reason == FlipperReason::missing_ground);
  REQUIRE(!d.missing.empty());
  for (const CellIndex& cell : d.missing) CHECK(cell.i >= 13);
  CHECK(d.angle_rad[0] == -0.5);
  CHECK(d.angle_rad[1] == -0.5);
  CHECK(!moves(d));
  const int feels = said_in_a_row(*policy, ground.view(), in, FlipperVerdict::feel, now, d);
  CHECK(feels == 60);  // 3 s, one of them above
  CHECK(d.verdict == FlipperVerdict::creep);
  CHECK(d.speed_limit_m_s == Approx(0.05));
  const int creeps = said_in_a_row(*policy, ground.view(), in, FlipperVerdict::creep, now, d);
  CHECK(creeps == 200);  // 10 s
  CHECK(d.verdict == FlipperVerdict::stop);
  CHECK(said_in_a_row(*policy, ground.view(), in, FlipperVerdict::stop, now, d) > 1000);
  CHECK(policy->counters().looked == 1);
  // Seen at last: on.
  const CellGround flat = CellGround::of([](double, double) { return 0.0; });
  in.stamp_ns = in.map_ns = in.attitude_ns = in.flippers_ns = now + kSafetyJob_ns;
  REQUIRE(policy->decide(flat.view(), in, d) == Status::ok);
  CHECK(moves(d));
}

TEST_CASE("flippers: who has looked need not wait, and who cannot creep stops", "[planner][flippers]") {
  CellGround ground = CellGround::of([](double, double) { return 0.0; });
  for (int j = -CellGround::kHalf; j < CellGround::kHalf; ++j)
    for (int i = 6; i < CellGround::kHalf; ++i) ground.at(i, j) = {};  // from 0.3 m on: under the nose
  const auto policy = flipper_policy();
  FlipperInput in = flipper_input(kSafetyJob_ns, {0.0, 0.0, 0.0}, kLevel_m);
  FlipperDecision d;
  REQUIRE(policy->decide(ground.view(), in, d) == Status::ok);
  CHECK(d.verdict == FlipperVerdict::look);
  in.stamp_ns = in.map_ns = in.attitude_ns = in.flippers_ns = 2 * kSafetyJob_ns;
  in.looked = true;
  REQUIRE(policy->decide(ground.view(), in, d) == Status::ok);
  CHECK(d.verdict == FlipperVerdict::stop);
  CHECK(policy->counters().felt == 1);  // entered and left at once: what is under the nose is open
  CHECK(policy->counters().crept == 1);
}

}  // namespace sortie::planner
