// SPDX-License-Identifier: BSD-3-Clause
// The flight estimator with its inertial sensor off the body's origin: a spin in closed form.
#include <catch2/catch.hpp>
#include <cmath>

#include "estimators/uav_state/uav_estimator.hpp"

namespace {
using namespace sortie;

// At rest for 0.5 s, then within 0.5 s up to 3 rad/s about the vertical, and on: the rate and its change.
struct Spin {
  double rate_rad_s;
  double change_rad_s2;
};
Spin spin_at(double t_s) {
  if (t_s <= 0.5) return {0.0, 0.0};
  if (t_s >= 1.0) return {3.0, 0.0};
  return {6.0 * (t_s - 0.5), 6.0};
}

// Flies the spin on the spot, with a fix at its start only; gives how far off the estimate is at its end.
double spun_away_m(const rt::Vector3& arm_m, const rt::Vector3& told_m, double seconds) {
  estimators::UavEstimatorConfig config;
  config.p_body_imu_m = told_m;
  estimators::UavEstimator estimator(config);
  const auto steps = static_cast<std::int64_t>(std::llround(seconds / 0.005));
  for (std::int64_t i = 0; i <= steps; ++i) {
    const double t = 5e-3 * static_cast<double>(i);
    const Spin spin = spin_at(t - 2.5e-3);  // in the middle of the interval: its mean
    const rt::Vector3 w{0, 0, spin.rate_rad_s};
    const rt::Vector3 f = rt::Vector3{0, 0, 9.81} + rt::cross(w, rt::cross(w, arm_m)) +
                          rt::cross(rt::Vector3{0, 0, spin.change_rad_s2}, arm_m);
    rt::ImuSample sample;
    sample.stamp_ns = 1'000'000 + i * 5'000'000;
    sample.flags = rt::kImuGyr | rt::kImuAcc;
    rt::store(w, sample.gyr_rad_s);
    rt::store(f, sample.acc_m_s2);
    REQUIRE(estimator.imu(sample, 9.81) == Status::ok);
    if (t > 0.3 && t < 0.5 && i % 10 == 0) {
      rt::UavFix fix;
      fix.stamp_ns = sample.stamp_ns;
      fix.flags = rt::kFixPosition | rt::kFixYaw;
      REQUIRE(estimator.fix(fix) == Status::ok);
    }
  }
  return rt::norm(estimator.now().p_world_m);
}
}  // namespace

TEST_CASE("A spin about the origin does not move the estimate, wherever the inertial sensor sits") {
  const rt::Vector3 arms[] = {{}, {0.2, 0, 0}, {0, -0.3, 0.1}, {0.1, 0.2, -0.2}};
  for (const rt::Vector3& arm : arms) {
    INFO(arm.x << ' ' << arm.y << ' ' << arm.z);
    // The change of rate is known half an interval late: where it begins and where it ends, the velocity
    // comes off by at most half an interval's worth of it, and nothing takes that back in the 3.5 s that
    // follow.
    const double late_m_s = 2 * 0.5 * 0.005 * 6.0 * rt::norm(arm);
    CHECK(spun_away_m(arm, arm, 4.0) <= 3.5 * late_m_s + 1e-9);
  }
}

TEST_CASE("An estimator that is not told of its sensor's place takes the spin for motion") {
  // 3 rad/s at 0.2 m: it comes off by more than the arm within the first turn.
  CHECK(spun_away_m({0.2, 0, 0}, {}, 4.0) > 0.2);
}
