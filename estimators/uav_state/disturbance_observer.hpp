// SPDX-License-Identifier: BSD-3-Clause
// Acceleration that the expected thrust does not explain: wind, gusts, a mass that is off.
#pragma once

#include <algorithm>

#include "rt/archive.hpp"
#include "rt/rotation.hpp"

namespace sortie::estimators {

/// Settings of the observer.
struct DisturbanceConfig {
  double bandwidth_hz{10.0};   ///< held within a tenth of the rate of updates: above it the loop rings
  double limit_m_s2{8.0};      ///< size of the result
};

/// d = LP2(R f - c b3): measured specific force in the world less the expected collective acceleration along the
/// body's z, through a critically damped low-pass of second order, stepped by exact decay. 100 bytes, no heap.
class DisturbanceObserver {
 public:
  explicit DisturbanceObserver(const DisturbanceConfig& config) : config_(config) {}

  void reset() { first_ = second_ = {}; }

  /// One interval of `dt_s` above 0: mean specific force in the body, attitude in its middle, mean expected
  /// thrust over mass. All finite.
  void update(const rt::Vector3& force_body_m_s2, const rt::Quaternion& q_world_body, double thrust_m_s2,
              double dt_s) {
    const rt::Vector3 rest{force_body_m_s2.x, force_body_m_s2.y, force_body_m_s2.z - thrust_m_s2};
    const rt::Vector3 seen = rt::rotate(q_world_body, rest);
    if (dt_s != keep_dt_s_) {
      constexpr double kTurn = 6.283185307179586;
      keep_dt_s_ = dt_s;
      keep_ = rt::exp(-kTurn * std::min(config_.bandwidth_hz, 0.1 / dt_s) * dt_s);
    }
    first_ = seen + keep_ * (first_ - seen);
    second_ = first_ + keep_ * (second_ - first_);
    const double size = rt::norm(second_);
    if (size > config_.limit_m_s2) second_ = (config_.limit_m_s2 / size) * second_;
  }

  /// In the world frame.
  const rt::Vector3& value_m_s2() const { return second_; }

  /// State to bytes and back.
  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "disturbance observer").fixed(config_).state(first_, second_, keep_, keep_dt_s_);
  }

 private:
  DisturbanceConfig config_;
  rt::Vector3 first_;
  rt::Vector3 second_;
  double keep_{};
  double keep_dt_s_{};
};

}  // namespace sortie::estimators
