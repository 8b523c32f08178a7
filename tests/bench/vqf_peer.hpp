// SPDX-License-Identifier: BSD-3-Clause
// A peer for the attitude filter: six-axis VQF with both bias estimators, written from its description
// (D. Laidig, T. Seel: VQF, Information Fusion 91, 2023) with its published parameters. It does all its work
// at every sample, in double precision, with one fixed sample time, and checks nothing, as its model does.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace sortie::bench {

/// About 1 kB; no heap. `gyr` in rad/s, `acc` in m/s^2.
class VqfPeer {
 public:
  using Vector = std::array<double, 3>;
  using Quaternion = std::array<double, 4>;  ///< w, x, y, z

  explicit VqfPeer(double sample_time_s) : ts_(sample_time_s) {
    acc_low_pass_ = design(kAccTime_s);
    rest_low_pass_ = design(kRestTime_s);
    const double initial = kSigmaInitial * 100;
    initial_variance_ = initial * initial;
    growth_ = 0.1 * 100 * 0.1 * 100 * ts_ / kForgetting_s;
    motion_weight_ = weight(kSigmaMotion);
    rest_weight_ = weight(kSigmaRest);
    variance_ = {initial_variance_, 0, 0, 0, initial_variance_, 0, 0, 0, initial_variance_};
  }

  void update(const Vector& gyr, const Vector& acc) {
    take_gyr(gyr);
    take_acc(acc);
  }

  /// Attitude, body to world.
  Quaternion attitude() const { return product(q_level_, q_gyr_); }
  const Vector& bias() const { return bias_; }
  bool at_rest() const { return at_rest_; }

 private:
  static constexpr double kAccTime_s = 3.0;
  static constexpr double kRestTime_s = 0.5;
  static constexpr double kRestLeast_s = 1.5;
  static constexpr double kDegree = 3.14159265358979323846 / 180;
  static constexpr double kRestGyr = 2.0 * kDegree;
  static constexpr double kRestAcc = 0.5;
  static constexpr double kSigmaInitial = 0.5;  // deg/s, as all sigmas
  static constexpr double kSigmaMotion = 0.1;
  static constexpr double kSigmaRest = 0.03;
  static constexpr double kForgetting_s = 100;
  static constexpr double kClip = 2.0 * kDegree;
  static constexpr double kVerticalForgetting = 1e-4;

  struct Coefficients {
    double b0, b1, b2, a1, a2;
  };

  /// Second-order Butterworth section; the mean of the first time constant starts it.
  template <std::size_t N>
  struct LowPass {
    std::array<double, N> sum{}, s0{}, s1{};
    double count{};
    bool running{};

    std::array<double, N> step(const std::array<double, N>& in, const Coefficients& c, double ts,
                               double tau) {
      std::array<double, N> out{};
      if (!running) {
        count += 1;
        running = count * ts >= tau;
        for (std::size_t i = 0; i < N; ++i) {
          sum[i] += in[i];
          out[i] = sum[i] / count;
          if (!running) continue;
          s0[i] = out[i] * (1 - c.b0);
          s1[i] = out[i] * (c.b2 - c.a2);
        }
        return out;
      }
      for (std::size_t i = 0; i < N; ++i) {
        out[i] = c.b0 * in[i] + s0[i];
        s0[i] = c.b1 * in[i] - c.a1 * out[i] + s1[i];
        s1[i] = c.b2 * in[i] - c.a2 * out[i];
      }
      return out;
    }
  };

  Coefficients design(double tau) const {
    const double cut_hz = std::sqrt(2.0) / (2 * 3.14159265358979323846 * tau);
    const double c = std::tan(3.14159265358979323846 * cut_hz * ts_);
    const double d = c * c + std::sqrt(2.0) * c + 1;
    const double b0 = c * c / d;
    return {b0, 2 * b0, b0, 2 * (c * c - 1) / d, (1 - std::sqrt(2.0) * c + c * c) / d};
  }
  double weight(double sigma) const {
    const double p = sigma * 100 * sigma * 100;
    return p * p / growth_ + p;
  }
  static Quaternion product(const Quaternion& a, const Quaternion& b) {
    return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
  }
  static void normalise(Quaternion& q) {
    const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& part : q) part /= n;
  }
  static std::array<double, 9> matrix(const Quaternion& q) {
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    return {1 - 2 * y * y - 2 * z * z, 2 * (y * x - w * z),       2 * (w * y + z * x),
            2 * (w * z + y * x),       1 - 2 * x * x - 2 * z * z, 2 * (z * y - x * w),
            2 * (z * x - w * y),       2 * (x * w + z * y),       1 - 2 * x * x - 2 * y * y};
  }
  static Vector turned(const Quaternion& q, const Vector& v) {
    const std::array<double, 9> r = matrix(q);
    return {r[0] * v[0] + r[1] * v[1] + r[2] * v[2], r[3] * v[0] + r[4] * v[1] + r[5] * v[2],
            r[6] * v[0] + r[7] * v[1] + r[8] * v[2]};
  }

  void take_gyr(const Vector& gyr) {
    rest_gyr_ = rest_gyr_filter_.step(gyr, rest_low_pass_, ts_, kRestTime_s);
    double away = 0;
    bool fast = false;
    for (std::size_t i = 0; i < 3; ++i) {
      away += (gyr[i] - rest_gyr_[i]) * (gyr[i] - rest_gyr_[i]);
      fast = fast || std::fabs(rest_gyr_[i]) > kClip;
    }
    if (away >= kRestGyr * kRestGyr || fast) {
      rest_s_ = 0;
      at_rest_ = false;
    }
    const Vector w{gyr[0] - bias_[0], gyr[1] - bias_[1], gyr[2] - bias_[2]};
    const double rate = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    const double angle = rate * ts_;
    if (rate > 1e-15) {
      const double s = std::sin(0.5 * angle) / rate;
      q_gyr_ = product(q_gyr_, {std::cos(0.5 * angle), s * w[0], s * w[1], s * w[2]});
      normalise(q_gyr_);
    }
  }

  void take_acc(const Vector& acc) {
    if (acc[0] == 0 && acc[1] == 0 && acc[2] == 0) return;
    rest_acc_ = rest_acc_filter_.step(acc, rest_low_pass_, ts_, kRestTime_s);
    double away = 0;
    for (std::size_t i = 0; i < 3; ++i) away += (acc[i] - rest_acc_[i]) * (acc[i] - rest_acc_[i]);
    if (away >= kRestAcc * kRestAcc) {
      rest_s_ = 0;
      at_rest_ = false;
    } else {
      rest_s_ += ts_;
      at_rest_ = at_rest_ || rest_s_ >= kRestLeast_s;
    }
    const Vector force = acc_filter_.step(turned(q_gyr_, acc), acc_low_pass_, ts_, kAccTime_s);
    Vector up = turned(q_level_, force);
    const double size = std::sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
    for (double& part : up) part /= size;
    const double w = std::sqrt(0.5 * (up[2] + 1));
    const Quaternion correction =
        w > 1e-6 ? Quaternion{w, 0.5 * up[1] / w, -0.5 * up[0] / w, 0} : Quaternion{0, 1, 0, 0};
    q_level_ = product(correction, q_level_);
    normalise(q_level_);
    learn_bias(up);
  }

  void learn_bias(const Vector& up) {
    std::array<double, 9> r = matrix(attitude());
    const std::array<double, 2> seen{r[0] * bias_[0] + r[1] * bias_[1] + r[2] * bias_[2],
                                     r[3] * bias_[0] + r[4] * bias_[1] + r[5] * bias_[2]};
    r = turn_filter_.step(r, acc_low_pass_, ts_, kAccTime_s);
    const std::array<double, 2> slow = bias_filter_.step(seen, acc_low_pass_, ts_, kAccTime_s);
    Vector e{};
    Vector weights{};
    if (at_rest_) {
      for (std::size_t i = 0; i < 3; ++i) e[i] = rest_gyr_[i] - bias_[i];
      r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
      weights = {rest_weight_, rest_weight_, rest_weight_};
    } else {
      e[0] = -up[1] / ts_ + slow[0] - r[0] * bias_[0] - r[1] * bias_[1] - r[2] * bias_[2];
      e[1] = up[0] / ts_ + slow[1] - r[3] * bias_[0] - r[4] * bias_[1] - r[5] * bias_[2];
      e[2] = -r[6] * bias_[0] - r[7] * bias_[1] - r[8] * bias_[2];
      weights = {motion_weight_, motion_weight_, motion_weight_ / kVerticalForgetting};
    }
    for (std::size_t i = 0; i < 9; i += 4) {
      if (variance_[i] < initial_variance_) variance_[i] += growth_;
    }
    for (double& part : e) part = std::fmax(-kClip, std::fmin(kClip, part));
    // K = P R' (W + R P R')^-1
    const std::array<double, 9> rp = times(r, variance_);
    std::array<double, 9> s = times(rp, transposed(r));
    for (std::size_t i = 0; i < 3; ++i) s[4 * i] += weights[i];
    const std::array<double, 9> gain = times(times(variance_, transposed(r)), inverse(s));
    const std::array<double, 9> less = times(gain, rp);
    for (std::size_t i = 0; i < 3; ++i) {
      bias_[i] += gain[3 * i] * e[0] + gain[3 * i + 1] * e[1] + gain[3 * i + 2] * e[2];
      bias_[i] = std::fmax(-kClip, std::fmin(kClip, bias_[i]));
    }
    for (std::size_t i = 0; i < 9; ++i) variance_[i] -= less[i];
  }

  static std::array<double, 9> times(const std::array<double, 9>& a, const std::array<double, 9>& b) {
    std::array<double, 9> c{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j)
        c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
    }
    return c;
  }
  static std::array<double, 9> transposed(const std::array<double, 9>& a) {
    return {a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]};
  }
  static std::array<double, 9> inverse(const std::array<double, 9>& m) {
    const double a = m[4] * m[8] - m[5] * m[7];
    const double b = m[5] * m[6] - m[3] * m[8];
    const double c = m[3] * m[7] - m[4] * m[6];
    const double d = 1 / (m[0] * a + m[1] * b + m[2] * c);
    return {a * d, (m[2] * m[7] - m[1] * m[8]) * d, (m[1] * m[5] - m[2] * m[4]) * d,
            b * d, (m[0] * m[8] - m[2] * m[6]) * d, (m[2] * m[3] - m[0] * m[5]) * d,
            c * d, (m[1] * m[6] - m[0] * m[7]) * d, (m[0] * m[4] - m[1] * m[3]) * d};
  }

  double ts_;
  Coefficients acc_low_pass_{}, rest_low_pass_{};
  double initial_variance_{}, growth_{}, motion_weight_{}, rest_weight_{};
  Quaternion q_gyr_{1, 0, 0, 0}, q_level_{1, 0, 0, 0};
  Vector bias_{}, rest_gyr_{}, rest_acc_{};
  std::array<double, 9> variance_{};
  LowPass<3> rest_gyr_filter_, rest_acc_filter_, acc_filter_;
  LowPass<9> turn_filter_;
  LowPass<2> bias_filter_;
  double rest_s_{};
  bool at_rest_{};
};

}  // namespace sortie::bench
