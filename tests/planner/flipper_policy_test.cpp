// SPDX-License-Identifier: BSD-3-Clause
// The flippers' policy where it may go, what it refuses, mirrored and written down.
#include "planner/flipper_policy.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/planner/flipper_rig.hpp"

namespace sortie::planner {
namespace {
constexpr rt::Nanoseconds kJob_ns = 50 * rt::kNanosecondsPerMillisecond;
constexpr double kFlatOrigin_m = 0.07192;
}  // namespace

TEST_CASE("flippers: a rest that is far from the last one is a fall", "[planner][flippers]") {
  const FlipperLimits limits;
  Posture good;
  good.rest = Rest::stands;
  good.margin_m = 0.2;
  good.clearance_m = 0.1;
  const auto safe_after = [&](double pitch, double roll) {
    FlipperWalk walk;
    Posture next = good;
    next.pitch_rad = pitch;
    next.roll_rad = roll;
    walk.add(good, false, limits);
    walk.add(next, false, limits);
    return walk.safe;
  };
  CHECK(safe_after(0.49, 0.0));
  CHECK(safe_after(0.0, -0.49));
  CHECK(!safe_after(0.51, 0.0));
  CHECK(!safe_after(-0.51, 0.0));
  CHECK(!safe_after(0.0, 0.51));
  FlipperWalk narrow;
  good.margin_m = 0.029;
  narrow.add(good, false, limits);
  CHECK(!narrow.safe);
  FlipperWalk steep;
  good.margin_m = 0.2;
  good.pitch_rad = steep.tilt.pitch_rad = 0.76;
  steep.add(good, false, limits);
  CHECK(!steep.safe);
}

TEST_CASE("flippers: on known flat ground it goes, whatever the arc", "[planner][flippers]") {
  const CellGround flat = CellGround::of([](double, double) { return 0.0; });
  const auto policy = flipper_policy();
  rt::Nanoseconds now = 0;
  for (const WantedArc arc : {WantedArc{0.2, 0.0}, {-0.2, 0.0}, {0.0, 0.5}, {0.2, -0.4}}) {
    FlipperInput in = flipper_input(now += kJob_ns, {0.3, -0.2, 0.7}, kFlatOrigin_m);
    in.arc = arc;
    FlipperDecision d;
    REQUIRE(policy->decide(flat.view(), in, d) == Status::ok);
    INFO("speed " << arc.speed_m_s << " turn " << arc.turn_rad_s << ": " << to_string(d.reason));
    CHECK((d.verdict == FlipperVerdict::go || d.verdict == FlipperVerdict::slow));
    CHECK(moves(d));
    CHECK(d.probability == 0.0);
    CHECK(d.margin_m > 0.1);
    CHECK(d.missing.empty());
    CHECK(d.units <= policy->searched().config().units);
  }
}

TEST_CASE("flippers: what it cannot judge it leaves to the mission, and says why", "[planner][flippers]") {
  const CellGround flat = CellGround::of([](double, double) { return 0.0; });
  const auto policy = flipper_policy();
  rt::Nanoseconds now = 10 * rt::kNanosecondsPerSecond;
  const auto reason = [&](rt::Nanoseconds FlipperInput::*stamp, rt::Nanoseconds age_ns) {
    FlipperInput in = flipper_input(now += kJob_ns, {}, kFlatOrigin_m);
    in.*stamp = now - age_ns;
    FlipperDecision d;
    REQUIRE(policy->decide(flat.view(), in, d) == Status::ok);
    if (d.verdict == FlipperVerdict::mission) {
      for (const double angle : d.angle_rad) CHECK(angle == 0.7);
      CHECK(d.share == 1.0);
      CHECK(d.probability == 1.0);
    }
    return d.reason;
  };
  constexpr rt::Nanoseconds kMs = rt::kNanosecondsPerMillisecond;
  CHECK(reason(&FlipperInput::map_ns, 501 * kMs) == FlipperReason::stale_map);
  CHECK(reason(&FlipperInput::attitude_ns, 201 * kMs) == FlipperReason::lost_attitude);
  CHECK(reason(&FlipperInput::flippers_ns, 301 * kMs) == FlipperReason::lost_flippers);
  CHECK(reason(&FlipperInput::map_ns, -1) == FlipperReason::stale_map);
  CHECK(policy->counters().fell_back == 4);
  CHECK(reason(&FlipperInput::map_ns, 499 * kMs) != FlipperReason::stale_map);
  CHECK(policy->counters().fell_back == 4);
}

TEST_CASE("flippers: a map that is not where the vehicle stands is not believed", "[planner][flippers]") {
  const CellGround flat = CellGround::of([](double, double) { return 0.0; });
  const auto policy = flipper_policy();
  FlipperDecision d;
  FlipperInput in = flipper_input(kJob_ns, {}, kFlatOrigin_m + 0.3);
  REQUIRE(policy->decide(flat.view(), in, d) == Status::ok);
  CHECK(d.verdict == FlipperVerdict::look);
  CHECK(d.reason == FlipperReason::map_disagrees);
  in = flipper_input(2 * kJob_ns, {}, kFlatOrigin_m);
  in.pitch_rad = 1.1;
  REQUIRE(policy->decide(flat.view(), in, d) == Status::ok);
  CHECK(d.verdict == FlipperVerdict::stop);
  CHECK(d.reason == FlipperReason::tilted);
  in = flipper_input(3 * kJob_ns, {}, kFlatOrigin_m);
  in.arc = {};
  REQUIRE(policy->decide(flat.view(), in, d) == Status::ok);
  CHECK(d.reason == FlipperReason::still);
  CHECK(!moves(d));
}

TEST_CASE("flippers: a broken one is left where it is", "[planner][flippers]") {
  hil::Random random(5, 0x62726f6b);
  for (std::uint32_t broken = 1; broken < 16; ++broken) {
    const CellGround ground = CellGround::of(random_course(CourseFamily::boxes, random));
    const auto policy = flipper_policy();
    FlipperInput in = flipper_input(kJob_ns, {-1.0, 0.0, 0.0}, kFlatOrigin_m);
    for (double& angle : in.measured_rad) angle = random.uniform(-0.4, 1.2);
    if (!settle(ground.view(), in)) continue;
    in.broken = broken;
    FlipperDecision d;
    REQUIRE(policy->decide(ground.view(), in, d) == Status::ok);
    for (std::uint32_t f = 0; f < 4; ++f) {
      if ((broken >> f & 1u) != 0 && d.verdict != FlipperVerdict::feel)
        CHECK(d.angle_rad[f] == in.measured_rad[f]);
    }
  }
}

TEST_CASE("flippers: nothing of NaN passes, and bad times and sizes change nothing", "[planner][flippers]") {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const CellGround flat = CellGround::of([](double, double) { return 0.0; });
  const auto policy = flipper_policy();
  const FlipperInput good = flipper_input(kJob_ns, {}, kFlatOrigin_m);
  FlipperDecision d;
  d.tried = 77;
  const auto refused = [&](auto change) {
    FlipperInput in = good;
    change(in);
    const Status status = policy->decide(flat.view(), in, d);
    CHECK(d.tried == 77);
    return status;
  };
  for (const double bad : {kNaN, std::numeric_limits<double>::infinity()}) {
    CHECK(refused([&](FlipperInput& in) { in.pose.x_m = bad; }) == Status::not_finite);
    CHECK(refused([&](FlipperInput& in) { in.pose.y_m = bad; }) == Status::not_finite);
    CHECK(refused([&](FlipperInput& in) { in.pose.yaw_rad = bad; }) == Status::not_finite);
    CHECK(refused([&](FlipperInput& in) { in.z_m = bad; }) == Status::not_finite);
    CHECK(refused([&](FlipperInput& in) { in.pitch_rad = bad; }) == Status::not_finite);
    CHECK(refused([&](FlipperInput& in) { in.roll_rad = bad; }) == Status::not_finite);
    CHECK(refused([&](FlipperInput& in) { in.arc.speed_m_s = bad; }) == Status::not_finite);
    CHECK(refused([&](FlipperInput& in) { in.arc.turn_rad_s = bad; }) == Status::not_finite);
    for (int f = 0; f < 4; ++f) {
      CHECK(refused([&](FlipperInput& in) { in.measured_rad[f] = bad; }) == Status::not_finite);
      CHECK(refused([&](FlipperInput& in) { in.mission_rad[f] = bad; }) == Status::not_finite);
    }
  }
  CHECK(refused([](FlipperInput& in) { in.pose.x_m = 1e6; }) == Status::out_of_range);
  CHECK(refused([](FlipperInput& in) { in.arc.speed_m_s = 50; }) == Status::out_of_range);
  CHECK(refused([](FlipperInput& in) { in.measured_rad[2] = 1e3; }) == Status::out_of_range);
  HeightView none = flat.view();
  none.cell = nullptr;
  CHECK(policy->decide(none, good, d) == Status::out_of_range);
  none = flat.view();
  none.cell_m = kNaN;
  CHECK(policy->decide(none, good, d) == Status::not_finite);
  REQUIRE(policy->decide(flat.view(), good, d) == Status::ok);
  CHECK(policy->decide(flat.view(), good, d) == Status::time_repeated);
  FlipperInput late = good;
  --late.stamp_ns;
  CHECK(policy->decide(flat.view(), late, d) == Status::time_backwards);
  // Cells that are no numbers are missing.
  CellGround bad = flat;
  for (HeightCell& cell : bad.cells) cell.high_m = kNaN;
  FlipperInput next = flipper_input(2 * kJob_ns, {}, kFlatOrigin_m);
  REQUIRE(policy->decide(bad.view(), next, d) == Status::ok);
  CHECK(d.verdict == FlipperVerdict::look);
  for (const double angle : d.angle_rad) CHECK(std::isfinite(angle));
  FlipperPolicyConfig config;
  config.search.units = 10;
  CHECK(std::make_unique<FlipperPolicy>(PostureVehicle{}, config)->usable() == Status::out_of_range);
  config = {};
  config.search.weights.jump = kNaN;
  CHECK(std::make_unique<FlipperPolicy>(PostureVehicle{}, config)->usable() == Status::out_of_range);
}

TEST_CASE("flippers: a mirrored world has mirrored angles, bit for bit", "[planner][flippers]") {
  constexpr std::uint64_t kSeed = 900;
  int apart = 0, with_missing = 0;
  for (int k = 0; k < 60; ++k) {
    hil::Random random(kSeed + static_cast<std::uint64_t>(k), 0x6d697272);
    CellGround ground = CellGround::of(random_course(kCourseFamilies[k % 5], random));
    if (k % 3 != 0) ground.mask(0.3, 1 + k % 4, random);
    FlipperInput in =
        flipper_input(kJob_ns, {random.uniform(-1.2, 0.0), random.uniform(-0.3, 0.3), 0.0}, 0.0);
    in.pose.yaw_rad = random.uniform(-1.0, 1.0);
    if (k % 4 == 0) in.pose = {-0.9, 0.0, 0.0};
    for (double& angle : in.measured_rad) angle = random.uniform(-0.4, 1.2);
    in.arc = {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)};
    (void)settle(ground.view(), in);
    FlipperInput other = in;
    other.pose.y_m = -in.pose.y_m;
    other.pose.yaw_rad = -in.pose.yaw_rad;
    other.roll_rad = -in.roll_rad;
    other.arc.turn_rad_s = -in.arc.turn_rad_s;
    std::swap(other.measured_rad[0], other.measured_rad[1]);
    std::swap(other.measured_rad[2], other.measured_rad[3]);
    const auto policy = flipper_policy(), mirror = flipper_policy();
    FlipperDecision d, m;
    INFO("seed " << kSeed + static_cast<std::uint64_t>(k));
    for (int job = 1; job < 4; ++job) {
      in.stamp_ns = in.map_ns = in.attitude_ns = in.flippers_ns = job * kJob_ns;
      other.stamp_ns = other.map_ns = other.attitude_ns = other.flippers_ns = job * kJob_ns;
      ground.mirrored = false;
      REQUIRE(policy->decide(ground.view(), in, d) == Status::ok);
      ground.mirrored = true;
      REQUIRE(mirror->decide(ground.view(), other, m) == Status::ok);
      CHECK(d.verdict == m.verdict);
      CHECK(d.reason == m.reason);
      CHECK(d.probability == m.probability);
      CHECK(d.margin_m == m.margin_m);
      CHECK(d.share == m.share);
      CHECK(d.units == m.units);
      for (int f = 0; f < 4; ++f) CHECK(d.angle_rad[f] == m.angle_rad[f ^ 1]);
    }
    if (d.angle_rad[0] != d.angle_rad[1] && d.verdict == FlipperVerdict::go) ++apart;
    if (d.reason == FlipperReason::missing_ground) ++with_missing;
  }
  CAPTURE(apart, with_missing);
  CHECK(with_missing > 0);
}

TEST_CASE("flippers: a state goes on where it was written, and a false one is refused",
          "[planner][flippers]") {
  hil::Random random(3, 0x61726368);
  CellGround ground = CellGround::of(random_course(CourseFamily::boxes, random));
  ground.mask(0.5, 3, random);
  const auto policy = flipper_policy(), other = flipper_policy();
  FlipperDecision d, e;
  FlipperInput in = flipper_input(0, {-0.9, 0.1, 0.0}, kFlatOrigin_m);
  rt::Nanoseconds now = 0;
  const auto at = [&](rt::Nanoseconds stamp) {
    in.stamp_ns = in.map_ns = in.attitude_ns = in.flippers_ns = stamp;
    return in;
  };
  for (int k = 0; k < 50; ++k) REQUIRE(policy->decide(ground.view(), at(now += kJob_ns), d) == Status::ok);
  rt::Archive measure = rt::Archive::measuring();
  policy->archive(measure);
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  policy->archive(write);
  rt::Archive read = rt::Archive::reading(bytes);
  other->archive(read);
  REQUIRE(read.status() == Status::ok);
  for (int k = 0; k < 60; ++k) {
    in.pose.x_m += 0.002;
    now += kJob_ns;
    REQUIRE(policy->decide(ground.view(), at(now), d) == Status::ok);
    REQUIRE(other->decide(ground.view(), at(now), e) == Status::ok);
    CHECK(d.verdict == e.verdict);
    CHECK(d.units == e.units);
    for (int f = 0; f < 4; ++f) CHECK(d.angle_rad[f] == e.angle_rad[f]);
  }
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    std::vector<std::uint8_t> spoilt = bytes;
    spoilt[k] ^= 0xffu;
    rt::Archive again = rt::Archive::reading(spoilt);
    other->archive(again);
    const Status status = other->decide(ground.view(), at(now + 1000 * rt::kNanosecondsPerSecond), e);
    if (status != Status::ok) continue;
    for (const double angle : e.angle_rad) CHECK(std::fabs(angle) <= 100.0);
  }
}

}  // namespace sortie::planner
