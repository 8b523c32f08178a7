// SPDX-License-Identifier: BSD-3-Clause
// The vertical channel against a textbook filter, and over a fall that the kinematics do not see.
#include "estimators/vertical_channel.hpp"

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace {

using sortie::estimators::VerticalChannel;
using sortie::estimators::VerticalChannelConfig;
using sortie::estimators::VerticalStep;

/// The same filter in matrices of long double, Joseph's form.
class ChannelTwin {
 public:
  using Matrix = Eigen::Matrix<long double, 5, 5>;
  using Vector = Eigen::Matrix<long double, 5, 1>;
  explicit ChannelTwin(const VerticalChannelConfig& c) : c_(c), x_(Vector::Zero()), p_(Matrix::Zero()) {
    p_(1, 1) = 1e-4L;
    for (int i = 2; i < 5; ++i) p_(i, i) = static_cast<long double>(c.acc_bias_m_s2) * c.acc_bias_m_s2;
  }
  double update(const VerticalStep& s) {
    const long double dt = s.dt_s, old = x_(0);
    Matrix f = Matrix::Identity();
    f(0, 1) = dt;
    const long double up[3] = {s.up_body.x, s.up_body.y, s.up_body.z};
    for (int i = 0; i < 3; ++i) {
      f(0, 2 + i) = -up[i] * dt * dt / 2;
      f(1, 2 + i) = -up[i] * dt;
    }
    const long double a = static_cast<long double>(s.force_m_s2) - c_.gravity_m_s2;
    Vector drive = Vector::Zero();
    drive(0) = a * dt * dt / 2;
    drive(1) = a * dt;
    x_ = f * x_ + drive;
    const long double q = static_cast<long double>(c_.acc_m_s2_rt_hz) * c_.acc_m_s2_rt_hz;
    Matrix noise = Matrix::Zero();
    noise(0, 0) = q * dt * dt * dt / 3;
    noise(0, 1) = noise(1, 0) = q * dt * dt / 2;
    noise(1, 1) = q * dt;
    for (int i = 2; i < 5; ++i)
      noise(i, i) = static_cast<long double>(c_.acc_walk_m_s2_rt_s) * c_.acc_walk_m_s2_rt_s * dt;
    p_ = f * p_ * f.transpose() + noise;
    const long double own = speed_variance(s);
    Vector h = Vector::Zero();
    h(1) = 1;
    h(2) = s.travel_m / dt * std::sqrt(1 - up[0] * up[0]) / c_.gravity_m_s2;
    const long double pull = a - up[0] * x_(2) - up[1] * x_(3) - up[2] * x_(4);
    const long double missed = s.rise_m / dt + pull * dt / 2 - h.dot(x_);
    const long double known = h.dot(p_ * h);
    const long double r = std::max(own, missed * missed / (c_.outlier * c_.outlier) - known);
    const Vector k = p_ * h / (known + r);
    x_ += k * missed;
    const Matrix keep = Matrix::Identity() - k * h.transpose();
    p_ = keep * p_ * keep.transpose() + k * r * k.transpose();
    return static_cast<double>(x_(0) - old);
  }
  /// A step of which the kinematics alone tell: the speed is theirs and owes nothing to what was before.
  double skip(const VerticalStep& s) {
    const long double dt = s.dt_s;
    const long double tilt = s.up_body.x;
    const long double rise = s.rise_m - s.travel_m * std::sqrt(1 - tilt * tilt) /
                                            static_cast<long double>(c_.gravity_m_s2) * x_(2);
    x_(0) += rise;
    x_(1) = rise / dt;
    p_.row(1).setZero();
    p_.col(1).setZero();
    p_(1, 1) = speed_variance(s);
    p_(0, 0) += p_(1, 1) * dt * dt;
    return static_cast<double>(rise);
  }
  double height_variance() const { return static_cast<double>(p_(0, 0)); }

 private:
  long double speed_variance(const VerticalStep& s) const {
    const long double speed = std::fabs(s.travel_m) / s.dt_s;
    const long double plane = c_.speed_m_s + c_.speed_share * speed;
    const long double mode = s.sigma_m / s.dt_s;
    return (plane * plane * c_.speed_keeps_s + mode * mode * c_.mode_keeps_m / (speed + 0.02L)) / s.dt_s;
  }

  VerticalChannelConfig c_;
  Vector x_;
  Matrix p_;
};

}  // namespace

TEST_CASE("The vertical channel agrees with a textbook filter in long double") {
  const unsigned seed = 31;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto uniform = [&](double most) { return most * (static_cast<double>(random()) / 2147483648.0 - 1); };
  VerticalChannel channel{VerticalChannelConfig{}};
  ChannelTwin twin{VerticalChannelConfig{}};
  double height = 0;
  for (int i = 0; i < 5000; ++i) {
    const double pitch = 0.4 * std::sin(0.01 * i);
    const VerticalStep s{0.01 + 0.005 * (i % 3), 0.002 * (1 + i % 5),
                         uniform(0.002),         i % 50 < 20 ? 0.001 : 0.0,
                         9.81 + uniform(0.5),    {std::sin(pitch), 0.1, std::cos(pitch)}};
    const bool felt = i % 97 > 6;  // now and then some steps without a force
    const double own = felt ? channel.update(s) : channel.skip(s);
    REQUIRE(own == Approx(felt ? twin.update(s) : twin.skip(s)).margin(1e-9));
    REQUIRE(channel.height_variance_m2() == Approx(twin.height_variance()).epsilon(1e-6));
    height += own;
  }
  CHECK(channel.height_m() == Approx(height).margin(1e-9));
  CHECK(channel.height_variance_m2() > 0);
}

TEST_CASE("A fall that kinematics miss is felt, and a biased accelerometer costs little") {
  for (const double bias : {0.0, 0.02, -0.02}) {
    VerticalChannel channel{VerticalChannelConfig{}};
    const double dt = 0.01;
    double z = 0;
    double v = 0;
    for (int i = 0; i < 1500; ++i) {
      // Level for 10 s, then down by 8 cm in half a second (cosine), then level.
      const double t = dt * i - 10.0;
      const double pi = 3.14159265358979323846;
      const double next =
          t < 0 || t >= 0.5 ? 0.0 : -0.08 * pi * std::sin(2 * pi * t) * std::sin(2 * pi * t) * 4 / pi;
      const double acceleration = (next - v) / dt;
      z += 0.5 * (v + next) * dt;
      v = next;
      const bool falls = t >= 0 && t < 0.5;
      static_cast<void>(
          channel.update({dt, 0.0015, 0.0, falls ? 0.01 : 0.0, 9.81 + bias + acceleration, {0, 0, 1}}));
    }
    INFO("bias " << bias);
    CHECK(z == Approx(-0.08).margin(1e-3));
    CHECK(channel.height_m() == Approx(z).margin(0.003));
    CHECK(channel.bias_m_s2().z == Approx(bias).margin(0.004));
  }
}

TEST_CASE("The lean that a bias along the body makes is seen on a slope, and its height is taken back") {
  for (const double bias : {0.034, -0.034}) {
    for (const double speed : {0.05, 0.15, 0.5, -0.15}) {
      VerticalChannel channel{VerticalChannelConfig{}};
      const double dt = 0.01;
      const double gravity = 9.81;
      double z = 0, told = 0, pitch = 0;
      // Level for 2 m, up a slope of 25 degrees within a quarter of a metre, 1 m of it. The attitude leans by
      // bias / g in body axes; the force along its idea of up is what the biased accelerometer feels.
      for (double s = 0; s < 3.25; s += std::fabs(speed) * dt) {
        const double next = 0.436 * std::min(1.0, std::max(0.0, (s - 2.0) / 0.25)) * (speed > 0 ? 1 : -1);
        const double lean = bias / gravity;
        const double rise = speed * dt * std::sin(0.5 * (pitch + next));
        const double leant = speed * dt * std::sin(0.5 * (pitch + next) + lean);
        const double before = speed * std::sin(pitch);
        const double up = gravity + (speed * std::sin(next) - before) / dt;
        const double force = up * std::cos(lean) + bias * (std::sin(next + lean) - std::sin(lean));
        pitch = next;
        z += rise;
        told += leant;
        const sortie::rt::Vector3 seen{std::sin(pitch + lean), 0, std::cos(pitch + lean)};
        // At level the accelerometer feels (bias, g): along its idea of up, g to second order.
        static_cast<void>(channel.update({dt, speed * dt, leant, 0.0, force, seen}));
      }
      INFO("bias " << bias << " speed " << speed << ": kinematics off by " << told - z);
      CHECK(std::fabs(told - z) > 0.009);
      CHECK(std::fabs(channel.height_m() - z) < 0.5 * std::fabs(told - z));
      CHECK(channel.bias_m_s2().x == Approx(bias).margin(0.4 * std::fabs(bias)));
    }
  }
}

TEST_CASE("On level ground a lean is not seen, and nothing is made up") {
  VerticalChannel channel{VerticalChannelConfig{}};
  double told = 0;
  for (int i = 0; i < 3000; ++i) {
    const double rise = 0.0015 * 0.0035;
    told += rise;
    static_cast<void>(channel.update({0.01, 0.0015, rise, 0.0, 9.81, {0.0035, 0, 1}}));
  }
  CHECK(channel.height_m() == Approx(told).margin(5e-4));
}

TEST_CASE("Without an accelerometer the height is the kinematics'") {
  VerticalChannel channel{VerticalChannelConfig{}};
  double sum = 0;
  for (int i = 0; i < 100; ++i) sum += channel.skip({0.01, 0.001, 1e-4 * i, 0.0, 0.0, {0, 0, 1}});
  CHECK(channel.height_m() == Approx(sum).margin(1e-15));
  CHECK(channel.height_variance_m2() > 0);
}
