// SPDX-License-Identifier: BSD-3-Clause
// Acceleration that the expected thrust does not explain: wind, gusts, a mass that is off.
#pragma once

#include <algorithm>

#include "rt/archive.hpp"
#include "rt/rotation.hpp"

namespace sortie::estimators {

/// Settings of the observer.
struct DisturbanceConfig {
  double across_hz{10.0};  ///< bandwidth square to the rotors' axis, where only air acts
  double along_hz{3.0};    ///< and along it, where the thrust answers: a late or wrong thrust feeds back
  double limit_m_s2{8.0};  ///< size of the result
};

/// d = LP2(R f - c b3): measured specific force in the world less the expected collective acceleration along
/// the body's z, through critically damped low-passes of second order, stepped by exact decay. Both
/// bandwidths are held within a tenth of the rate of updates: above it the loop through the controller rings.
/// 200 bytes, no heap.
class DisturbanceObserver {
 public:
  explicit DisturbanceObserver(const DisturbanceConfig& config) : config_(config) {}

  /// Forgets what was estimated. The filters keep their step as it is: the watch of the rotors is tuned so.
  void reset() { across_ = along_ = {}; }

  /// The world's axes turn: what was taken for one direction was another.
  void turn(const rt::Quaternion& by) {
    for (rt::Vector3* each : {&across_.first, &across_.second, &along_.first, &along_.second, &value_})
      *each = rt::rotate(by, *each);
  }

  /// One interval of `dt_s` above 0: mean specific force in the body, attitude in its middle, mean expected
  /// thrust over mass. All finite.
  void update(const rt::Vector3& force_body_m_s2, const rt::Quaternion& q_world_body, double thrust_m_s2,
              double dt_s) {
    if (dt_s != keep_dt_s_) {
      keep_dt_s_ = dt_s;
      across_.keep = kept(config_.across_hz, dt_s);
      along_.keep = kept(config_.along_hz, dt_s);
    }
    across_.step(rt::rotate(q_world_body, {force_body_m_s2.x, force_body_m_s2.y, 0.0}));
    along_.step(rt::rotate(q_world_body, {0.0, 0.0, force_body_m_s2.z - thrust_m_s2}));
    value_ = across_.second + along_.second;
    const double size = rt::norm(value_);
    if (size > config_.limit_m_s2) value_ = (config_.limit_m_s2 / size) * value_;
  }

  /// In the world frame.
  const rt::Vector3& value_m_s2() const { return value_; }

  /// State to bytes and back.
  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "disturbance observer")
        .fixed(config_)
        .state(across_, along_, value_, keep_dt_s_);
  }

 private:
  struct LowPass {
    rt::Vector3 first;
    rt::Vector3 second;
    double keep{};
    SORTIE_FIELDS(first, second, keep)

    void step(const rt::Vector3& seen) {
      first = seen + keep * (first - seen);
      second = first + keep * (second - first);
    }
  };

  static double kept(double hz, double dt_s) {
    constexpr double kTurn = 6.283185307179586;
    return rt::exp(-kTurn * std::min(hz, 0.1 / dt_s) * dt_s);
  }

  DisturbanceConfig config_;
  LowPass across_;
  LowPass along_;
  rt::Vector3 value_;
  double keep_dt_s_{};
};

}  // namespace sortie::estimators
