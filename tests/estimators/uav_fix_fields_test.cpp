// SPDX-License-Identifier: BSD-3-Clause
// The flight estimator and fixes that do not carry all they could: what is absent is not read, on no way.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <vector>

#include "tests/estimators/uav_flight.hpp"

namespace {
using namespace sortie;
using namespace sortie::estimators::test;
using estimators::UavEstimator;
using rt::UavVerdict;

constexpr std::uint32_t kBothFields = rt::kFixPosition | rt::kFixYaw;

// What a fix says that is not as the flight is.
enum class Wrong { nothing, place, heading, both };

rt::UavFix wrong_fix(SimulatedFlight& flight, rt::Nanoseconds now, Wrong wrong, std::uint32_t flags) {
  rt::UavFix fix = flight.fix(now);
  if (wrong == Wrong::place || wrong == Wrong::both) fix.p_world_m[1] += 5.0;
  if (wrong == Wrong::heading || wrong == Wrong::both) fix.yaw_rad = rt::wrap_angle(fix.yaw_rad + 1.0);
  fix.flags = flags;
  return fix;
}

// The same with `junk` where nothing is.
rt::UavFix littered(rt::UavFix fix, double junk) {
  if ((fix.flags & rt::kFixPosition) == 0) {
    for (double& each : fix.p_world_m) each = junk;
  }
  if ((fix.flags & rt::kFixYaw) == 0) fix.yaw_rad = junk;
  return fix;
}

// Bit for bit.
bool same(const UavEstimator& a, const UavEstimator& b) {
  return a.state().verdict == b.state().verdict &&
         std::memcmp(&a.state(), &b.state(), offsetof(rt::UavState, verdict)) == 0 &&
         std::memcmp(&a.now(), &b.now(), sizeof(estimators::InertialState)) == 0 &&
         std::memcmp(&a.covariance(), &b.covariance(), sizeof(estimators::ErrorCovariance)) == 0 &&
         std::memcmp(&a.counters(), &b.counters(), sizeof(estimators::UavEstimatorCounters)) == 0;
}

std::uint64_t seen_fixes(const UavEstimator& estimator) {
  const estimators::UavEstimatorCounters& c = estimator.counters();
  return c.fixes_used + c.fixes_refused + c.fixes_gated;
}

// Readings up to `i` steps, a fix every ten: `fix(now)` makes it, `after(status)` looks.
template <class Make, class Look>
void fly(UavEstimator& estimator, SimulatedFlight& flight, std::int64_t from, std::int64_t to, Make make,
         Look look) {
  for (std::int64_t i = from + 1; i <= to; ++i) {
    REQUIRE(estimator.imu(flight.imu(i * kStepNs), 9.81) == Status::ok);
    if (i % 10 != 0) continue;
    const rt::UavFix fix = make(i * kStepNs);
    look(estimator.fix(fix), fix);
  }
}
}  // namespace

TEST_CASE("What a fix does not carry is not read, whatever it carries and however wrong it is") {
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double junk : {nan, infinity, 1e300, 1e30, -2.0, 5.0}) {
    UavEstimator plain(matched_config());
    UavEstimator junked(matched_config());
    SimulatedFlight flight(21);
    std::uint64_t given = 0;
    std::int64_t i = 0;
    const auto phase = [&](Wrong wrong, std::uint32_t flags, int fixes) {
      CAPTURE(junk, static_cast<int>(wrong), flags);
      int refused = 0;
      int yaws_refused = 0;
      for (const std::int64_t end = i + 10 * fixes; i < end;) {
        const rt::ImuSample sample = flight.imu(++i * kStepNs);
        REQUIRE(plain.imu(sample, 9.81) == Status::ok);
        REQUIRE(junked.imu(sample, 9.81) == Status::ok);
        if (i % 10 != 0) continue;
        const rt::UavFix fix = wrong_fix(flight, i * kStepNs, wrong, flags);
        const std::uint64_t yaws = junked.counters().yaws_gated + junked.counters().reheaded;
        const Status expected = plain.fix(littered(fix, 0.0));
        const Status status = junked.fix(littered(fix, junk));
        ++given;
        REQUIRE(status == expected);
        REQUIRE(same(plain, junked));
        REQUIRE(seen_fixes(junked) == given);
        // No verdict is good while everything of one kind is refused.
        refused = status == Status::ok ? 0 : refused + 1;
        const bool yaw_refused = junked.counters().yaws_gated + junked.counters().reheaded == yaws + 1;
        yaws_refused = yaw_refused ? yaws_refused + 1 : 0;
        if (refused > 7 || yaws_refused > 7) REQUIRE(junked.state().verdict != UavVerdict::good);
      }
    };
    phase(Wrong::nothing, kBothFields, 40);
    REQUIRE(junked.state().verdict == UavVerdict::good);
    for (const std::uint32_t flags : {0u, +rt::kFixPosition, +rt::kFixYaw, kBothFields}) {
      for (const Wrong wrong : {Wrong::nothing, Wrong::place, Wrong::heading, Wrong::both}) {
        phase(wrong, flags, 12);
        phase(Wrong::nothing, kBothFields, 12);
        CAPTURE(junk, static_cast<int>(wrong), flags);
        CHECK(junked.state().verdict == UavVerdict::good);
      }
    }
    // Place: wrong place and back, with position alone and with both, each of two wrongs. Heading alike.
    CHECK(junked.counters().relocated == 8);
    CHECK(junked.counters().reheaded == 8);
  }
}

TEST_CASE("The first fix carries both or none is taken, and its absent fields are not read either") {
  for (const std::uint32_t flags : {0u, +rt::kFixPosition, +rt::kFixYaw}) {
    UavEstimator estimator(matched_config());
    SimulatedFlight flight(22);
    fly(
        estimator, flight, 0, 100,
        [&](rt::Nanoseconds now) {
          return littered(wrong_fix(flight, now, Wrong::nothing, flags), std::nan(""));
        },
        [&](Status status, const rt::UavFix&) { CHECK(status == Status::empty); });
    CHECK(estimator.state().verdict == UavVerdict::starting);
    CHECK(estimator.counters().fixes_refused == 10);
  }
}

TEST_CASE("Places alone that agree move the position, not the heading") {
  // At rest at the origin, looking 2 rad to the left.
  UavEstimator estimator{estimators::UavEstimatorConfig{}};
  UavEstimator twin{estimators::UavEstimatorConfig{}};  // was never anywhere else
  rt::ImuSample rest;
  rest.flags = rt::kImuGyr | rt::kImuAcc;
  rest.acc_m_s2[2] = 9.81;
  rt::UavFix fix;
  int used = 0;
  for (int i = 1; i <= 6000; ++i) {
    rest.stamp_ns = i * kStepNs;
    REQUIRE(estimator.imu(rest, 9.81) == Status::ok);
    REQUIRE(twin.imu(rest, 9.81) == Status::ok);
    if (i % 10 != 0) continue;
    const int n = i / 10;
    fix.stamp_ns = rest.stamp_ns;
    fix.flags = n > 20 && n <= 28 ? +rt::kFixPosition : kBothFields;
    fix.yaw_rad = (fix.flags & rt::kFixYaw) != 0 ? 2.0 : 0.0;
    fix.p_world_m[0] = n > 20 ? 5.0 : 0.0;
    const Status status = estimator.fix(fix);
    fix.p_world_m[0] = 5.0;
    static_cast<void>(twin.fix(fix));
    if (n == 28) {
      CHECK(status == Status::ok);
      CHECK(estimator.counters().relocated == 1);
      CHECK(estimator.state().p_world_m[0] == Approx(5.0).margin(1e-6));
      CHECK(rt::yaw_of(estimator.now().q_world_body) == Approx(2.0).margin(1e-6));
      // As sure of the heading as one that was not moved.
      CHECK(estimator.covariance()(8, 8) == Approx(twin.covariance()(8, 8)).epsilon(1e-3));
    }
    if (n > 28) {
      used += status == Status::ok ? 1 : 0;
      REQUIRE(estimator.state().verdict == UavVerdict::good);
    }
  }
  CHECK(used == 600 - 28);
  CHECK(estimator.counters().yaws_gated == 0);
  CHECK(rt::norm(estimator.now().p_world_m - twin.now().p_world_m) < 1e-3);
}

TEST_CASE("The velocity after a relocation is that of the fixes, whatever they carry") {
  for (const std::uint32_t flags : {+rt::kFixPosition, kBothFields}) {
    for (const std::uint64_t seed : {31, 32, 33, 34}) {
      CAPTURE(flags, seed);
      UavEstimator estimator(matched_config());
      UavEstimator twin(matched_config());  // its fixes lie there from the beginning
      SimulatedFlight flight(seed);
      bool moved = false;
      for (std::int64_t i = 1; i <= 1400 && !moved; ++i) {
        const rt::ImuSample sample = flight.imu(i * kStepNs);
        REQUIRE(estimator.imu(sample, 9.81) == Status::ok);
        REQUIRE(twin.imu(sample, 9.81) == Status::ok);
        if (i % 10 != 0) continue;
        rt::UavFix fix = flight.fix(i * kStepNs);
        const double y = fix.p_world_m[1];
        if (i > 1000) fix.flags = flags;
        fix.p_world_m[1] = y + (i > 1000 ? 2.0 : 0.0);
        static_cast<void>(estimator.fix(fix));
        fix.p_world_m[1] = y + 2.0;
        static_cast<void>(twin.fix(fix));
        moved = estimator.counters().relocated == 1;
      }
      REQUIRE(moved);
      const rt::Vector3 v = SimulatedFlight::velocity(rt::to_seconds(estimator.state().stamp_ns));
      REQUIRE(rt::norm(v) > 0.5);  // else a zero would do
      // Two fixes 0.35 s apart: 0.048 m/s an axis; five sigmas.
      CHECK(rt::norm(estimator.now().v_world_m_s - twin.now().v_world_m_s) < 0.25);
      CHECK(rt::norm(estimator.now().v_world_m_s - v) < 0.25);
    }
  }
}

TEST_CASE("A vehicle that is carried along takes the speed of its fixes, and a fast one is found again") {
  // Its inertial sensor says rest, or speeds up at 4 m/s^2 for 2 s; then fixes run on at 1 or 8 m/s, 5 m off.
  for (const bool fast : {false, true}) {
    UavEstimator estimator{estimators::UavEstimatorConfig{}};
    double x = 0.0;
    double v = 0.0;
    rt::UavFix fix;
    fix.flags = kBothFields;
    for (int i = 1; i <= 1200 && estimator.counters().relocated == 0; ++i) {
      const double t = 0.005 * i;
      const double a = fast && t > 1.0 && t <= 3.0 ? 4.0 : 0.0;
      x += 0.005 * (v + 0.5 * 0.005 * a);
      v += 0.005 * a;
      rt::ImuSample sample;
      sample.stamp_ns = i * kStepNs;
      sample.flags = rt::kImuGyr | rt::kImuAcc;
      sample.acc_m_s2[0] = a;
      sample.acc_m_s2[2] = 9.81;
      REQUIRE(estimator.imu(sample, 9.81) == Status::ok);
      if (i % 10 != 0) continue;
      fix.stamp_ns = sample.stamp_ns;
      fix.p_world_m[0] = t <= 3.5 ? x : fast ? x + 5.0 : 5.0 + 1.0 * (t - 3.5);
      static_cast<void>(estimator.fix(fix));
    }
    CAPTURE(fast);
    REQUIRE(estimator.counters().relocated == 1);
    CHECK(estimator.now().v_world_m_s.x == Approx(fast ? 8.0 : 1.0).margin(0.05));
  }
}

TEST_CASE("Eight copies of one refused fix are one fix") {
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(23);
  const auto good = [&](rt::Nanoseconds now) { return flight.fix(now); };
  fly(estimator, flight, 0, 1000, good, [](Status, const rt::UavFix&) {});
  const rt::UavFix wrong = wrong_fix(flight, 1000 * kStepNs, Wrong::both, kBothFields);
  for (int i = 0; i < 20; ++i) CHECK(estimator.fix(wrong) == Status::out_of_range);
  CHECK(estimator.counters().relocated == 0);
  CHECK(estimator.counters().reheaded == 0);
}

TEST_CASE("A fix that is refused leaves no trace: others that are older are used as if it had not come") {
  // Fixes come 100 ms late. Between them come strays of now: places that do not agree, or headings alone.
  for (const std::uint32_t flags : {+rt::kFixPosition, +rt::kFixYaw, kBothFields, 0u}) {
    CAPTURE(flags);
    UavEstimator undisturbed(matched_config());
    UavEstimator estimator(matched_config());
    SimulatedFlight flight(24);
    std::vector<rt::UavFix> waiting;
    std::size_t used = 0;
    for (std::int64_t i = 1; i <= 1200; ++i) {
      const rt::ImuSample sample = flight.imu(i * kStepNs);
      REQUIRE(undisturbed.imu(sample, 9.81) == Status::ok);
      REQUIRE(estimator.imu(sample, 9.81) == Status::ok);
      if (i % 10 != 0) continue;
      waiting.push_back(flight.fix(i * kStepNs));
      if (i > 400) {
        rt::UavFix stray = waiting.back();
        stray.flags = flags;
        stray.p_world_m[0] += i % 20 == 0 ? 7.0 : -7.0;
        stray.yaw_rad = rt::wrap_angle(stray.yaw_rad + (i % 20 == 0 ? 1.0 : -1.0));
        REQUIRE(estimator.fix(stray) != Status::ok);
      }
      if (waiting.size() <= 2) continue;
      const rt::UavFix& late = waiting[waiting.size() - 3];
      const Status expected = undisturbed.fix(late);
      REQUIRE(estimator.fix(late) == expected);
      used += expected == Status::ok ? 1 : 0;
      const estimators::InertialState& a = estimator.now();
      const estimators::InertialState& b = undisturbed.now();
      REQUIRE(std::memcmp(&a, &b, sizeof a) == 0);
      REQUIRE(std::memcmp(&estimator.covariance(), &undisturbed.covariance(),
                          sizeof(estimators::ErrorCovariance)) == 0);
      REQUIRE(estimator.state().verdict == undisturbed.state().verdict);
    }
    CHECK(used > 100);
    CHECK(estimator.state().verdict == UavVerdict::good);
  }
}
