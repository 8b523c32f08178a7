// SPDX-License-Identifier: BSD-3-Clause
// The flight estimator: late fixes, consistency, dead reckoning, gating and broken samples.
#include "estimators/uav_state/uav_estimator.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/estimators/uav_flight.hpp"

namespace {
using namespace sortie;
using namespace sortie::estimators::test;
using estimators::UavEstimator;
using rt::Vector3;

// Flies `seconds`, a fix every 50 ms that comes `late` steps later, none between the two dark times.
void fly_estimator(UavEstimator& estimator, SimulatedFlight& flight, double seconds, int late,
                   double dark_from_s = 1e9, double dark_to_s = 1e9) {
  std::vector<std::pair<rt::Nanoseconds, rt::UavFix>> waiting;
  const auto steps = static_cast<std::int64_t>(std::llround(seconds / 0.005));
  for (std::int64_t i = 1; i <= steps; ++i) {
    const rt::Nanoseconds now = i * kStepNs;
    REQUIRE(estimator.imu(flight.imu(now), 9.81) == Status::ok);
    const double t = rt::to_seconds(now);
    if (i % 10 == 0) {
      const rt::UavFix fix = flight.fix(now);
      if (t < dark_from_s || t >= dark_to_s) waiting.push_back({now + late * kStepNs, fix});
    }
    while (!waiting.empty() && waiting.front().first <= now) {
      (void)estimator.fix(waiting.front().second);
      waiting.erase(waiting.begin());
    }
  }
}

double position_error(const UavEstimator& estimator) {
  const double t = rt::to_seconds(estimator.state().stamp_ns);
  return rt::norm(estimator.now().p_world_m - SimulatedFlight::position(t));
}
}  // namespace

TEST_CASE("A fix that comes late gives exactly what it would have given in time") {
  for (const int late : {1, 7, 12, 40}) {
    UavEstimator in_time(matched_config());
    UavEstimator waiting(matched_config());
    SimulatedFlight one(11);
    SimulatedFlight two(11);
    fly_estimator(in_time, one, 6.0, 0);
    fly_estimator(waiting, two, 6.0, late);
    // Both have the same readings; the late one has not yet seen the newest fixes. Let it catch up on a copy.
    SimulatedFlight three(11);
    UavEstimator early(matched_config());
    fly_estimator(early, three, 6.0, 0, 6.0 - 0.005 * late + 0.0001, 1e9);
    INFO("late by " << late << " readings");
    CHECK(rt::norm(early.now().p_world_m - waiting.now().p_world_m) < 1e-12);
    CHECK(rt::norm(early.now().v_world_m_s - waiting.now().v_world_m_s) < 1e-12);
    for (std::size_t i = 0; i < estimators::kErrorStates; ++i)
      CHECK(waiting.covariance()(i, i) == Approx(early.covariance()(i, i)).epsilon(1e-9));
  }
}

TEST_CASE("The covariance tells the truth about the errors of position, velocity and biases") {
  // Mean squared error over variance, 40 flights: 12 degrees of freedom each, so 5 sigma of the mean are
  // 0.32.
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    UavEstimator estimator(matched_config());
    SimulatedFlight flight(seed);
    fly_estimator(estimator, flight, 12.0, 10);
    const double t = rt::to_seconds(estimator.state().stamp_ns);
    const estimators::InertialState& now = estimator.now();
    const Vector3 offs[5] = {now.p_world_m - SimulatedFlight::position(t),
                             now.v_world_m_s - SimulatedFlight::velocity(t),
                             rt::log_rotation(rt::conjugate(now.q_world_body) * SimulatedFlight::attitude(t)),
                             now.gyr_bias_rad_s - flight.gyr_bias(), now.acc_bias_m_s2 - flight.acc_bias()};
    for (std::size_t g = 0; g < 5; ++g) {
      const double parts[3] = {offs[g].x, offs[g].y, offs[g].z};
      for (std::size_t i = 0; i < 3; ++i) {
        sum += parts[i] * parts[i] / estimator.covariance()(3 * g + i, 3 * g + i);
        ++count;
      }
    }
  }
  CAPTURE(sum / count);
  CHECK(sum / count > 0.75);
  CHECK(sum / count < 1.3);
}

TEST_CASE("Without fixes it reckons on: the covariance grows, the verdict falls, and a fix mends both") {
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(3);
  fly_estimator(estimator, flight, 8.5, 10, 8.0, 1e9);
  CHECK(estimator.state().verdict == rt::UavVerdict::dead);
  CHECK(position_error(estimator) < 0.1);
  const double sigma = estimator.state().position_sigma_m[0];
  const auto go_on = [&](double from_s, double to_s) {
    for (auto i = static_cast<std::int64_t>(std::llround(from_s / 0.005)) + 1;
         i <= std::llround(to_s / 0.005); ++i)
      REQUIRE(estimator.imu(flight.imu(i * kStepNs), 9.81) == Status::ok);
  };
  go_on(8.5, 11.5);
  CHECK(estimator.state().verdict == rt::UavVerdict::lost);
  CHECK(estimator.state().position_sigma_m[0] > 2 * sigma);
  const double t = rt::to_seconds(estimator.state().stamp_ns);
  CHECK(std::fabs(estimator.now().p_world_m.x - SimulatedFlight::position(t).x) <
        5 * estimator.state().position_sigma_m[0]);
  REQUIRE(estimator.fix(flight.fix(11'480'000'000)) == Status::ok);
  CHECK(estimator.state().verdict == rt::UavVerdict::good);
  CHECK(position_error(estimator) < 0.06);
}

TEST_CASE("A fix far off is gated, and fixes that agree for long enough are given in to") {
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(4);
  fly_estimator(estimator, flight, 6.0, 0);
  const Vector3 before = estimator.now().p_world_m;
  rt::UavFix wrong = flight.fix(6'000'000'000);
  wrong.p_world_m[0] += 1.0;
  CHECK(estimator.fix(wrong) == Status::out_of_range);
  CHECK(estimator.counters().fixes_gated == 1);
  CHECK(rt::norm(estimator.now().p_world_m - before) == 0);
  for (std::int64_t i = 1201; i <= 1400; ++i) {
    REQUIRE(estimator.imu(flight.imu(i * kStepNs), 9.81) == Status::ok);
    if (i % 10 != 0) continue;
    rt::UavFix moved = flight.fix(i * kStepNs);
    moved.p_world_m[1] += 2.0;
    (void)estimator.fix(moved);
  }
  CHECK(estimator.counters().relocated == 1);
  const double t = rt::to_seconds(estimator.state().stamp_ns);
  CHECK(estimator.now().p_world_m.y == Approx(SimulatedFlight::position(t).y + 2.0).margin(0.1));
  CHECK(estimator.state().verdict == rt::UavVerdict::good);
}

TEST_CASE("Broken samples change nothing but a counter") {
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(5);
  fly_estimator(estimator, flight, 4.0, 4);
  const Vector3 before = estimator.now().p_world_m;
  const double infinity = std::numeric_limits<double>::infinity();
  rt::ImuSample sample = flight.imu(4'005'000'000);
  for (const double bad : {std::nan(""), infinity, 1e30}) {
    rt::ImuSample broken = sample;
    broken.acc_m_s2[1] = bad;
    CHECK(estimator.imu(broken, 9.81) != Status::ok);
    broken = sample;
    broken.gyr_rad_s[2] = -bad;
    CHECK(estimator.imu(broken, 9.81) != Status::ok);
    rt::UavFix fix = flight.fix(4'000'000'000);
    fix.p_world_m[2] = bad;
    CHECK(estimator.fix(fix) != Status::ok);
  }
  CHECK(estimator.imu(sample, std::nan("")) == Status::not_finite);
  sample.stamp_ns = 4'000'000'000;
  CHECK(estimator.imu(sample, 9.81) == Status::time_repeated);
  sample.stamp_ns = 3'000'000'000;
  CHECK(estimator.imu(sample, 9.81) == Status::time_backwards);
  CHECK(estimator.fix(flight.fix(1'000'000'000)) == Status::stale);
  CHECK(estimator.fix(flight.fix(9'000'000'000)) == Status::out_of_range);
  CHECK(rt::norm(estimator.now().p_world_m - before) == 0);
  CHECK(estimator.counters().imu_refused == 9);
}

TEST_CASE("One stamp far off is refused, and after a silence or a new clock the estimator begins anew") {
  const rt::Nanoseconds goes_on_ns = GENERATE(70'000'000'000, 1'000'000);
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(6);
  fly_estimator(estimator, flight, 4.0, 4);
  REQUIRE(estimator.state().verdict == rt::UavVerdict::good);
  rt::ImuSample sample = flight.imu(4'005'000'000);
  sample.stamp_ns = goes_on_ns > 4'000'000'000 ? 60'000'000'000 : 50'000'000;
  CHECK(estimator.imu(sample, 9.81) ==
        (goes_on_ns > 4'000'000'000 ? Status::out_of_range : Status::time_backwards));
  CHECK(estimator.imu(flight.imu(4'005'000'000), 9.81) == Status::ok);
  // At rest from a minute on, or from the beginning again: refused until eight agree, then levelled and
  // located again.
  rt::ImuSample rest;
  rest.flags = rt::kImuGyr | rt::kImuAcc;
  rest.acc_m_s2[2] = 9.81;
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    rest.stamp_ns = goes_on_ns + i * kStepNs;
    refused += estimator.imu(rest, 9.81) == Status::ok ? 0 : 1;
  }
  CHECK(refused == 7);
  CHECK(estimator.state().verdict == rt::UavVerdict::starting);
  rt::UavFix fix;
  fix.flags = rt::kFixPosition | rt::kFixYaw;
  fix.stamp_ns = rest.stamp_ns;
  fix.p_world_m[0] = 7.0;
  CHECK(estimator.fix(fix) == Status::ok);
  CHECK(estimator.state().verdict == rt::UavVerdict::good);
  CHECK(estimator.state().p_world_m[0] == Approx(7.0));
}

TEST_CASE("An estimator restored from bytes goes on as the one that was saved") {
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(6);
  fly_estimator(estimator, flight, 3.0, 4);
  rt::Archive measure = rt::Archive::measuring();
  estimator.archive(measure);
  INFO(measure.where() << ": " << measure.why());
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive out = rt::Archive::writing(bytes);
  estimator.archive(out);
  REQUIRE(out.status() == Status::ok);
  UavEstimator copy(matched_config());
  rt::Archive in = rt::Archive::reading(bytes);
  copy.archive(in);
  REQUIRE(in.status() == Status::ok);
  for (std::int64_t i = 601; i < 700; ++i) {
    const rt::ImuSample sample = flight.imu(i * kStepNs);
    REQUIRE(estimator.imu(sample, 9.81) == Status::ok);
    REQUIRE(copy.imu(sample, 9.81) == Status::ok);
  }
  CHECK(rt::norm(copy.now().p_world_m - estimator.now().p_world_m) == 0);
}
