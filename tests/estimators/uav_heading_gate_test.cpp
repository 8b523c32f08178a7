// SPDX-License-Identifier: BSD-3-Clause
// The flight estimator's gate for headings: it gives in to what agrees, and the verdict says when nothing
// does.
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/estimators/uav_flight.hpp"

namespace {
using namespace sortie;
using namespace sortie::estimators::test;
using estimators::kErrorStates;
using estimators::UavEstimator;
using rt::UavVerdict;

constexpr int kStates = static_cast<int>(kErrorStates);
using Wide = Eigen::Matrix<long double, kStates, kStates>;
using WideVector = Eigen::Matrix<long double, kStates, 1>;

Wide wide(const estimators::ErrorCovariance& p) {
  Wide m;
  for (int r = 0; r < kStates; ++r) {
    for (int c = 0; c < kStates; ++c) m(r, c) = p(static_cast<std::size_t>(r), static_cast<std::size_t>(c));
  }
  return m;
}

// Flies up to a step, with fixes in time whose headings are off by `off(n)`.
template <class Off>
void fly_on(UavEstimator& estimator, SimulatedFlight& flight, std::int64_t from, std::int64_t to,
            std::uint32_t flags, Off off) {
  for (std::int64_t i = from + 1; i <= to; ++i) {
    REQUIRE(estimator.imu(flight.imu(i * kStepNs), 9.81) == Status::ok);
    if (i % 10 != 0) continue;
    rt::UavFix fix = flight.fix(i * kStepNs);
    fix.flags = flags;
    fix.yaw_rad = rt::wrap_angle(fix.yaw_rad + off(i / 10));
    static_cast<void>(estimator.fix(fix));
  }
}
constexpr std::uint32_t kPlaceAndHeading = rt::kFixPosition | rt::kFixYaw;
}  // namespace

TEST_CASE("A flight is the same in whatever direction it heads, half a turn and its wrap included") {
  const double turns[] = {0.0, 3.14159265358979323846 - 0.4, -3.0, 1.7};
  rt::Vector3 first;
  for (const double turn : turns) {
    CAPTURE(turn);
    const rt::Quaternion about = rt::from_yaw_pitch_roll(turn, 0, 0);
    UavEstimator estimator(matched_config());
    SimulatedFlight flight(41);
    bool wrapped = false;
    double before = 0;
    for (std::int64_t i = 1; i <= 2000; ++i) {
      REQUIRE(estimator.imu(flight.imu(i * kStepNs), 9.81) == Status::ok);
      if (i % 10 != 0) continue;
      rt::UavFix fix = flight.fix(i * kStepNs);
      rt::store(rt::rotate(about, rt::to_vector(fix.p_world_m)), fix.p_world_m);
      fix.yaw_rad = rt::wrap_angle(fix.yaw_rad + turn);
      wrapped = wrapped || fix.yaw_rad * before < -1.0;
      before = fix.yaw_rad;
      const Status status = estimator.fix(fix);
      if (i > 200) REQUIRE(status == Status::ok);  // levelled by then
    }
    CHECK(wrapped == (turn == turns[1]));
    CHECK(estimator.counters().yaws_gated == 0);
    const rt::Vector3 place = rt::rotate_back(about, estimator.now().p_world_m);
    if (turn == 0.0) first = place;
    CHECK(rt::norm(place - first) < 1e-6);
  }
}

TEST_CASE("Headings that agree are given in to, alone or with a place, and the motion stays") {
  for (const std::uint32_t flags : {+rt::kFixYaw, kPlaceAndHeading}) {
    for (const double off : {1.0, -2.5, 3.14159}) {
      CAPTURE(flags, off);
      UavEstimator estimator(matched_config());
      SimulatedFlight flight(41);
      fly_on(estimator, flight, 0, 800, kPlaceAndHeading, [](std::int64_t) { return 0.0; });
      const double before = rt::yaw_of(estimator.now().q_world_body);
      fly_on(estimator, flight, 800, 870, flags, [off](std::int64_t) { return off; });
      CHECK(estimator.counters().reheaded == 0);
      CHECK(std::fabs(rt::wrap_angle(rt::yaw_of(estimator.now().q_world_body) - before)) < 0.3);
      CHECK(estimator.counters().yaws_gated == 7);
      fly_on(estimator, flight, 870, 880, flags, [off](std::int64_t) { return off; });
      CHECK(estimator.counters().reheaded == 1);
      const double truth = rt::yaw_of(SimulatedFlight::attitude(880 * 0.005));
      const double error = rt::wrap_angle(rt::yaw_of(estimator.now().q_world_body) - truth - off);
      CHECK(std::fabs(error) < 5 * 0.012);
      // Its motion stays as the places say.
      CHECK(rt::norm(estimator.now().v_world_m_s - SimulatedFlight::velocity(880 * 0.005)) < 0.3);
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> values(wide(estimator.covariance()).cast<double>());
      CHECK(values.eigenvalues().minCoeff() > -1e-12);
    }
  }
}

TEST_CASE("A heading given in to leaves the covariance of an update of one that was not known at all") {
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(42);
  fly_on(estimator, flight, 0, 870, kPlaceAndHeading, [](std::int64_t n) { return n > 80 ? 1.0 : 0.0; });
  for (std::int64_t i = 871; i <= 880; ++i)
    REQUIRE(estimator.imu(flight.imu(i * kStepNs), 9.81) == Status::ok);
  const Wide p = wide(estimator.covariance());
  const rt::RotationMatrix r = rt::to_matrix(estimator.now().q_world_body);
  WideVector u = WideVector::Zero();
  WideVector h = WideVector::Zero();
  const long double level2 =
      static_cast<long double>(r.m[0]) * r.m[0] + static_cast<long double>(r.m[3]) * r.m[3];
  for (int i = 0; i < 3; ++i) u(6 + i) = r.m[6 + i];
  for (int i = 1; i < 3; ++i) h(6 + i) = r.m[6 + i] / level2;
  // The eighth, of now.
  rt::UavFix fix = flight.fix(880 * kStepNs);
  fix.yaw_rad = rt::wrap_angle(fix.yaw_rad + 1.0);
  fix.flags = rt::kFixYaw;
  REQUIRE(estimator.fix(fix) == Status::ok);
  REQUIRE(estimator.counters().reheaded == 1);
  // Of a heading that is not known at all the gain is u: the book's update in Joseph's form.
  const long double variance = 0.012L * 0.012L;
  REQUIRE(std::fabs(static_cast<double>(u.dot(h)) - 1.0) < 1e-12);
  const Wide rest = Wide::Identity() - u * h.transpose();
  Wide expected = rest * p * rest.transpose() + variance * u * u.transpose();
  if (std::numeric_limits<long double>::digits > std::numeric_limits<double>::digits) {
    // The same with a million square radians for unknown, where they may be subtracted from each other.
    const Wide unknown = p + 1e6L * u * u.transpose();
    const WideVector ph = unknown * h;
    const Wide book = unknown - ph * ph.transpose() / (h.dot(ph) + variance);
    CHECK(static_cast<double>((book - expected).cwiseAbs().maxCoeff()) < 1e-10);
  }
  // The velocity is known anew, to half a metre per second.
  expected.middleRows<3>(3).setZero();
  expected.middleCols<3>(3).setZero();
  expected.block<3, 3>(3, 3) = 0.25L * Eigen::Matrix<long double, 3, 3>::Identity();
  const Wide after = wide(estimator.covariance());
  CHECK(static_cast<double>((after - expected).cwiseAbs().maxCoeff()) < 1e-10);
}

TEST_CASE("Headings that never agree make the verdict fall, and one that fits mends it") {
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(43);
  fly_on(estimator, flight, 0, 800, kPlaceAndHeading, [](std::int64_t) { return 0.0; });
  const auto strays = [](std::int64_t n) { return n % 2 == 0 ? 1.0 : -1.0; };
  fly_on(estimator, flight, 800, 810, kPlaceAndHeading, strays);
  CHECK(estimator.state().verdict == UavVerdict::good);  // one may be wrong
  fly_on(estimator, flight, 810, 890, kPlaceAndHeading, strays);
  CHECK(estimator.state().verdict == UavVerdict::dead);
  fly_on(estimator, flight, 890, 1430, kPlaceAndHeading, strays);
  CHECK(estimator.state().verdict == UavVerdict::lost);
  CHECK(estimator.counters().reheaded == 0);
  CHECK(estimator.counters().fixes_gated == 0);  // their places were used
  fly_on(estimator, flight, 1430, 1440, kPlaceAndHeading, [](std::int64_t) { return 0.0; });
  CHECK(estimator.state().verdict == UavVerdict::good);
}

TEST_CASE("No heading at all is no doubt about it") {
  UavEstimator estimator(matched_config());
  SimulatedFlight flight(44);
  fly_on(estimator, flight, 0, 800, kPlaceAndHeading, [](std::int64_t) { return 0.0; });
  fly_on(estimator, flight, 800, 2400, rt::kFixPosition, [](std::int64_t) { return 0.0; });
  CHECK(estimator.state().verdict == UavVerdict::good);
}

TEST_CASE("A heading alone says nothing to a vehicle whose nose points up") {
  UavEstimator estimator{estimators::UavEstimatorConfig{}};
  rt::ImuSample sample;
  sample.flags = rt::kImuGyr | rt::kImuAcc;
  rt::UavFix fix;
  fix.flags = kPlaceAndHeading;
  // Levelled, then within 1 s up to 1.4 rad, on the spot.
  for (int i = 1; i <= 400; ++i) {
    const double t = 0.005 * i;
    const double pitched = t <= 0.5 ? 0.0 : t >= 1.5 ? 1.4 : 1.4 * (t - 0.5);
    const double middle = t <= 0.5 ? 0.0 : t > 1.5 ? 1.4 : 1.4 * (t - 0.5025);
    sample.stamp_ns = i * kStepNs;
    sample.gyr_rad_s[1] = t > 0.5025 && t < 1.5025 ? -1.4 : 0.0;
    rt::store(rt::rotate_back(rt::exp_rotation({0, -middle, 0}), {0, 0, 9.81}), sample.acc_m_s2);
    REQUIRE(estimator.imu(sample, 9.81) == Status::ok);
    fix.stamp_ns = sample.stamp_ns;
    if (i % 10 == 0 && i < 400 && pitched < 1.2) static_cast<void>(estimator.fix(fix));
  }
  REQUIRE(std::fabs(rt::rotate(estimator.now().q_world_body, {1, 0, 0}).z) > 0.97);
  const estimators::UavEstimatorCounters before = estimator.counters();
  fix.flags = rt::kFixYaw;
  fix.yaw_rad = 1.0;
  CHECK(estimator.fix(fix) == Status::empty);
  CHECK(estimator.counters().fixes_refused == before.fixes_refused + 1);
  CHECK(estimator.counters().yaws_gated == before.yaws_gated);
  fix.flags = kPlaceAndHeading;
  rt::store(estimator.now().p_world_m, fix.p_world_m);
  CHECK(estimator.fix(fix) == Status::ok);  // the place of one is used all the same
  CHECK(estimator.counters().yaws_gated == before.yaws_gated);
}
