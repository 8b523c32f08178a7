// SPDX-License-Identifier: BSD-3-Clause
// The covariance of the attitude against the errors of many simulated runs, and the bias filter against a
// plain Kalman filter in long double.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <random>

#include "estimators/gyro_bias.hpp"
#include "estimators/slow_value.hpp"
#include "tests/estimators/attitude_samples.hpp"

using namespace sortie;
using namespace sortie::estimators::test;
using estimators::Attitude;
using estimators::AttitudeConfig;

namespace {

class SeededNoise {
 public:
  explicit SeededNoise(std::uint32_t seed) : random_(seed) {}
  double one() {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random_() % 65536u) / 65536.0;
    return sum - 6;
  }
  Vector3 three(double sigma) {
    const double x = one();
    const double y = one();
    const double z = one();
    return sigma * Vector3{x, y, z};
  }

 private:
  std::mt19937 random_;
};

struct Nees {
  double tilt{};     // two degrees of freedom
  double heading{};  // one
};

/// Mean normalised square errors over `runs` of 120 s at 100 Hz: bias, walk and noise as the configuration
/// says, accelerations that are white.
Nees simulate(bool moving, std::uint32_t runs) {
  const AttitudeConfig config;
  constexpr double kStep_s = 0.01;
  Nees nees;
  double n = 0;
  for (std::uint32_t run = 0; run < runs; ++run) {
    SeededNoise noise(100 + run);
    Attitude filter{config};
    filter.set_moving(moving);
    Vector3 bias = noise.three(config.bias_sigma_initial_rad_s);
    const Vector3 acc_bias = noise.three(config.acc_bias_m_s2);
    Quaternion truth;
    for (int i = 1; i <= 12'000; ++i) {
      const double t = kStep_s * i;
      const bool turns = moving && t > 5;
      const Vector3 rate =
          turns ? Vector3{0.5 * std::sin(0.9 * t + run), 0.4 * std::sin(1.3 * t), 0.6 * std::sin(0.5 * t)}
                : Vector3{};
      bias = bias + noise.three(0.0017453 * std::sqrt(kStep_s / config.bias_forgetting_s));
      truth = normalised(truth * exp_rotation(kStep_s * rate));
      const Vector3 gyr = rate + bias + noise.three(config.gyr_noise_rad_s_rthz / std::sqrt(kStep_s));
      const Vector3 acc = rotate_back(truth, kGravity) + acc_bias + noise.three(moving ? 2.0 : 0.05);
      REQUIRE(filter.update(sample_of(i * 10 * kMs, gyr, acc, kBoth | rt::kImuMeanRate)) == Status::ok);
      if (i < 1000 || i % 500 != 0) continue;
      double p[9];
      filter.covariance(p);
      const Vector3 e = log_rotation(truth * conjugate(attitude_of(filter)));
      const double det = p[0] * p[4] - p[1] * p[3];
      REQUIRE(det > 0);
      nees.tilt += (e.x * e.x * p[4] - 2 * e.x * e.y * p[1] + e.y * e.y * p[0]) / det;
      nees.heading += e.z * e.z / p[8];
      n += 1;
    }
  }
  return {nees.tilt / n, nees.heading / n};
}

}  // namespace

TEST_CASE("The covariance fits the errors of simulated runs: never proud, at most careful", "[heavy]") {
  const Nees rest = simulate(false, 40);
  const Nees motion = simulate(true, 40);
  std::clog << "NEES at rest: inclination " << rest.tilt << " of 2, heading " << rest.heading
            << " of 1; moving: " << motion.tilt << " of 2, heading " << motion.heading << " of 1\n";
  // 40 runs with errors that last: the mean of 2 degrees of freedom scatters by about 0.3 (1 sigma).
  CHECK(rest.tilt < 3.0);
  CHECK(rest.tilt > 1.0);
  CHECK(motion.tilt < 3.0);
  CHECK(motion.tilt > 0.5);
  CHECK(rest.heading < 1.5);  // the gyro that turns the heading is also what the bias is read off: careful
  CHECK(motion.heading < 1.5);
  CHECK(motion.heading > 0.1);
}

TEST_CASE("The bias filter with its heading is a plain Kalman filter of four states, in long double") {
  // Twin: state (bias, heading error), full matrices, textbook order.
  SeededNoise noise(7);
  constexpr double kInitial = 7.6e-5;
  estimators::GyroBias<double> filter({0.001, -0.002, 0.003}, kInitial);
  long double x[4] = {0.001L, -0.002L, 0.003L, 0};
  long double p[4][4] = {};
  for (int i = 0; i < 3; ++i) p[i][i] = kInitial;
  double turned = 0;
  for (int n = 0; n < 3000; ++n) {
    const Vector3 u = noise.three(1);
    const double length = norm(u) + 1e-9;
    const estimators::VectorOf<double> row{u.x / length, u.y / length, u.z / length};
    constexpr double kDt = 0.035;
    filter.integrate(row, kDt, 1e-9);
    // heading' = heading - dt row . (bias error)
    const long double r[3] = {row.x, row.y, row.z};
    long double f[4][4] = {
        {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {-kDt * r[0], -kDt * r[1], -kDt * r[2], 1}};
    long double fp[4][4] = {};
    long double q[4][4] = {};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k) fp[i][j] += f[i][k] * p[k][j];
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k) q[i][j] += fp[i][k] * f[j][k];
    q[3][3] += 1e-9L;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) p[i][j] = q[i][j];
    if (n % 3 != 0) continue;
    constexpr double kGrowth = 1e-9;
    constexpr double kNoise = 3e-6;
    filter.grow(kGrowth, kInitial);
    for (int i = 0; i < 3; ++i)
      if (p[i][i] < kInitial) p[i][i] += kGrowth;
    const double seen = 0.004 * noise.one();
    turned += filter.observe(row, seen, kNoise, 1.0);
    long double s = kNoise;
    long double ph[4] = {};
    long double predicted = 0;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) ph[i] += p[i][k] * r[k];
    for (int k = 0; k < 3; ++k) {
      s += r[k] * ph[k];
      predicted += r[k] * x[k];
    }
    for (int i = 0; i < 4; ++i) x[i] += ph[i] / s * (seen - predicted);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) p[i][j] -= ph[i] * ph[j] / s;
  }
  CHECK(filter.value().x == Approx(static_cast<double>(x[0])).epsilon(1e-9));
  CHECK(filter.value().y == Approx(static_cast<double>(x[1])).epsilon(1e-9));
  CHECK(filter.value().z == Approx(static_cast<double>(x[2])).epsilon(1e-9));
  CHECK(turned == Approx(static_cast<double>(x[3])).epsilon(1e-9));
  CHECK(filter.heading_variance() == Approx(static_cast<double>(p[3][3])).epsilon(1e-9));
  CHECK(filter.covariance_along({1, 0, 0}, {0, 1, 0}) == Approx(static_cast<double>(p[0][1])).epsilon(1e-9));
}

TEST_CASE("The slow mean is a mean at first and then the Butterworth step response, over any steps") {
  std::mt19937 random(3);
  constexpr double kTau = 3.0;
  estimators::SlowValue<double> value;
  double age = 0;
  double sum = 0;
  while (age < kTau) {
    const double dt = 0.001 * static_cast<double>(1 + random() % 60);
    const double in = static_cast<double>(random() % 100);
    value.take(in, estimators::SlowStep<double>(dt, age, kTau));
    age += dt;
    sum += in * dt;
    REQUIRE(value.value == Approx(sum / age));
  }
  // From here a step to another level: 1 - sqrt(2) exp(-a) sin(a + pi/4), a = w t / sqrt(2), w = sqrt(2) /
  // tau.
  const double from = value.value;
  double t = 0;
  double worst = 0;
  while (t < 20) {
    const double dt = 0.001 * static_cast<double>(1 + random() % 60);
    value.take(from + 1, estimators::SlowStep<double>(dt, age, kTau));
    t += dt;
    const double a = t / kTau;
    const double exact = 1 - std::sqrt(2.0) * std::exp(-a) * std::sin(a + kPi / 4);
    worst = std::max(worst, std::fabs(value.value - from - exact));
  }
  CHECK(worst <
        0.06 * 0.06 * 2 / (kTau * kTau) / 12);  // (cut-off times the longest step)^2 / 12: the rule's own
  // Steps of ten seconds, the longest that a filter takes: stable.
  for (int i = 0; i < 50; ++i) value.take(5, estimators::SlowStep<double>(10, age, kTau));
  CHECK(std::fabs(value.value - 5) < 1e-3);
}
