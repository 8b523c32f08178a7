// SPDX-License-Identifier: BSD-3-Clause
// What a perfect strapdown IMU on a simulated body measures: exact increments of angle and velocity.
#pragma once

#include "hil/motion.hpp"

namespace sortie::hil {

/// Mean turn rate and mean specific force over an interval, in the axes of the body.
struct InertialTruth {
  Vec3 gyr_rad_s;
  Vec3 acc_m_s2;
};

/// Adds up, step by step, the angle and the velocity that an inertial sensor goes through, as real devices do
/// inside. Integrating its outputs gives the true attitude back. Cost: one atan2 a step.
class InertialSum {
 public:
  /// A step of `dt_s` between two attitudes; `dv_world`: change of velocity less that by gravity.
  void add(const Quat& q_before, const Quat& q_after, const Vec3& dv_world, double dt_s) {
    const Quat middle = blend(q_before, q_after, 0.5);
    dv_body_m_s_ = dv_body_m_s_ + rotate(conjugate(middle), dv_world);
    turn_rad_ = turn_rad_ + rotation_vector(conjugate(q_before) * q_after);
    span_s_ += dt_s;
  }

  /// Means since the last take(), which are then started anew. Zero if nothing was added.
  InertialTruth take() {
    const double scale = span_s_ > 0.0 ? 1.0 / span_s_ : 0.0;
    const InertialTruth mean{scale * turn_rad_, scale * dv_body_m_s_};
    *this = {};
    return mean;
  }

 private:
  Vec3 turn_rad_;
  Vec3 dv_body_m_s_;
  double span_s_{};
};

/// The same of a sensor on a body that moves.
class InertialIntegral {
 public:
  static constexpr double kGravity_m_s2 = 9.81;

  /// `lever_arm_m`: where the sensor sits, from the body's origin, body frame, whose axes are its own.
  explicit InertialIntegral(const Vec3& lever_arm_m) : lever_arm_m_(lever_arm_m) {}

  /// Adds the step between two states.
  void add(const Motion& before, const Motion& after) {
    const double dt_s = rt::to_seconds(after.stamp_ns - before.stamp_ns);
    const Vec3 dv_world = velocity(after) - velocity(before) + Vec3{0, 0, kGravity_m_s2 * dt_s};
    sum_.add(before.q_world_body, after.q_world_body, dv_world, dt_s);
  }
  /// As InertialSum::take().
  InertialTruth take() { return sum_.take(); }

 private:
  Vec3 velocity(const Motion& m) const {
    return m.v_world_m_s + rotate(m.q_world_body, cross(m.w_body_rad_s, lever_arm_m_));
  }

  Vec3 lever_arm_m_;
  InertialSum sum_;
};

}  // namespace sortie::hil
