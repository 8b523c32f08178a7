// SPDX-License-Identifier: BSD-3-Clause
// The simplest estimator that flies: gyro and gravity for the attitude, fixed gains for position and
// velocity.
#pragma once

#include <array>

#include "rt/rotation.hpp"
#include "rt/samples.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::bench {

/// A complementary filter: the gyro turns the attitude, the accelerometer pulls it level, a fix pulls the
/// heading; double integration gives the position, which fixes pull with fixed gains. A fix is compared with
/// where the filter was at its stamp. No covariance, no gate, no biases but the gyro's mean at rest.
class ComplementaryFilter {
 public:
  explicit ComplementaryFilter(double gravity_m_s2) : gravity_m_s2_(gravity_m_s2) {}

  void imu(const rt::ImuSample& sample) {
    const rt::Vector3 gyr = rt::to_vector(sample.gyr_rad_s);
    const rt::Vector3 acc = rt::to_vector(sample.acc_m_s2);
    const double dt_s = last_ns_ > 0 ? rt::to_seconds(sample.stamp_ns - last_ns_) : 0.0;
    last_ns_ = sample.stamp_ns;
    if (rest_s_ < kRest_s) {  // at rest: the gyro's bias
      rest_s_ += dt_s;
      bias_ = bias_ + (dt_s / kRest_s) * gyr;
    }
    w_ = gyr - bias_;
    // Level: what the accelerometer says is up less what the attitude says, slowly.
    const rt::Vector3 up = rt::rotate_back(q_, {0, 0, 1});
    const rt::Vector3 pull = rt::cross((1.0 / gravity_m_s2_) * acc, up);
    q_ = rt::normalised(q_ * rt::exp_rotation(dt_s * (w_ + kLevel_hz * pull)));
    rt::Vector3 a = rt::rotate(q_, acc);
    a.z -= gravity_m_s2_;
    if (!located_) return;
    p_ = p_ + dt_s * (v_ + (0.5 * dt_s) * a);
    v_ = v_ + dt_s * a;
    past_[next_] = {last_ns_, p_};
    next_ = (next_ + 1) % static_cast<std::uint32_t>(past_.size());
  }

  void fix(const rt::UavFix& fix) {
    const bool first = !located_;
    if ((fix.flags & rt::kFixPosition) != 0) take_place(fix);
    if (first || (fix.flags & rt::kFixYaw) == 0) return;
    const double turn = kHeading * rt::wrap_angle(fix.yaw_rad - rt::yaw_of(q_));
    q_ = rt::normalised(rt::exp_rotation({0, 0, turn}) * q_);
  }

  rt::UavState state() const {
    rt::UavState state;
    state.stamp_ns = last_ns_;
    state.verdict = located_ ? rt::UavVerdict::good : rt::UavVerdict::starting;
    rt::store(p_, state.p_world_m);
    rt::store(v_, state.v_world_m_s);
    rt::store(q_, state.q_world_body);
    rt::store(w_, state.w_body_rad_s);
    return state;
  }

 private:
  void take_place(const rt::UavFix& fix) {
    const rt::Vector3 seen = rt::to_vector(fix.p_world_m);
    if (!located_) {
      p_ = seen;
      located_ = true;
      return;
    }
    for (const Past& past : past_) {
      if (past.stamp_ns == 0 || past.stamp_ns < fix.stamp_ns - 2'500'000 ||
          past.stamp_ns > fix.stamp_ns + 2'500'000)
        continue;
      const rt::Vector3 off = seen - past.p_m;
      p_ = p_ + kPlace * off;
      v_ = v_ + kSpeed_hz * off;
      for (Past& each : past_) each.p_m = each.p_m + kPlace * off;
      break;
    }
  }

  static constexpr double kRest_s = 1.0;
  static constexpr double kLevel_hz = 0.05;
  static constexpr double kPlace = 0.25;    // of a fix, 20 a second
  static constexpr double kSpeed_hz = 0.7;  // critically damped with it, by and large
  static constexpr double kHeading = 0.1;
  struct Past {
    rt::Nanoseconds stamp_ns{};
    rt::Vector3 p_m;
  };
  double gravity_m_s2_;
  double rest_s_{};
  rt::Nanoseconds last_ns_{};
  bool located_{};
  rt::Vector3 bias_;
  rt::Vector3 w_;
  rt::Vector3 p_;
  rt::Vector3 v_;
  rt::Quaternion q_;
  std::array<Past, 32> past_{};
  std::uint32_t next_{};
};

}  // namespace sortie::bench
