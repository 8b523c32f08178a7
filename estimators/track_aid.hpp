// SPDX-License-Identifier: BSD-3-Clause
// What the tracks know of the acceleration that the accelerometer cannot tell from gravity.
#pragma once

#include "estimators/attitude_config.hpp"
#include "estimators/real_rotation.hpp"

namespace sortie::estimators {

/// Acceleration of the inertial sensor from the robot's own velocity. The mean acceleration over a block is
/// the difference of the world velocities at its ends over its time: braking, centripetal part and lever arm
/// are all in it, nothing is differentiated twice, and an error of the velocity cancels with the next block,
/// also when trust is lost or found between the two. Trusted while it explains the specific force; judged on,
/// and so taken back, also while it is not.
template <class Real>
class TrackAid {
 public:
  /// Velocity of the body's origin, body axes, m/s, at `stamp_ns` of the sensor's clock.
  void set_velocity(const VectorOf<Real>& v_body_m_s, rt::Nanoseconds stamp_ns) {
    v_body_ = v_body_m_s;
    stamp_ns_ = stamp_ns;
    known_ = true;
  }
  /// The velocity at the end of the block before says nothing about the next one.
  void interrupt() { running_ = false; }

  /// Takes the tracks' part out of `force` (world, mean of a block of `dt_s` that ended at `now_ns` with
  /// attitude `turn` and rate `w_body`). `up_force` is the mean force: its direction is up. `cut` is what was
  /// left out of `force` as an outlier. True when the tracks have just lost trust.
  bool correct(const AttitudeConfig& config, const MatrixOf<Real>& turn, const VectorOf<Real>& w_body,
               rt::Nanoseconds now_ns, Real dt_s, Real up_force, const VectorOf<Real>& cut,
               VectorOf<Real>& force) {
    aided_ = false;
    const rt::Nanoseconds age_ns = now_ns - stamp_ns_;
    if (!known_ || age_ns > config.max_aid_age_ns || age_ns < -config.max_aid_age_ns) {
      running_ = false;
      return false;
    }
    const VectorOf<Real> arm = vector_of<Real>(config.p_body_imu_m);
    const VectorOf<Real> velocity = turn * (v_body_ + cross(w_body, arm));
    const VectorOf<Real> last = velocity_;
    velocity_ = velocity;
    if (!running_) {
      running_ = true;
      taken_ = velocity;
      late_cut_ = late_left_ = {};
      return false;
    }
    const VectorOf<Real> acceleration = (Real{1} / dt_s) * (velocity - last);
    if (trusted_) {
      force = force + believed_cut(force - acceleration - VectorOf<Real>{0, 0, up_force}, cut);
    } else {
      late_cut_ = late_left_ = {};
    }
    // What is left of the force beside gravity, without aid and with it; horizontal: the tilt is at stake.
    const Real weight = dt_s / (static_cast<Real>(config.aid_window_s) + dt_s);
    const VectorOf<Real> plain{force.x, force.y, 0};
    const VectorOf<Real> rest{force.x - acceleration.x, force.y - acceleration.y, 0};
    plain_ = plain_ + weight * (plain - plain_);
    rest_ = rest_ + weight * (rest - rest_);
    const Real margin = static_cast<Real>(config.aid_disagreement_m_s2);
    const Real excess = dot(rest_, rest_) - dot(plain_, plain_);
    const bool trusted_before = trusted_;
    trusted_ = excess < (trusted_ ? Real{1} : Real{0.25}) * margin * margin;
    aided_ = trusted_ && up_force > Real{0};
    // A wild velocity that loses trust and comes to its end with trust again would leave half of itself in
    // the mean force. So the difference is the one to what was taken out last; what happened without aid
    // since then counts as long as it is looked at.
    if (aided_) {
      force = force - (Real{1} / dt_s) * (velocity - taken_);
      taken_ = velocity;
    } else {
      taken_ = taken_ + weight * (velocity - taken_);
    }
    return trusted_before && !trusted_;
  }

  bool aided() const { return aided_; }
  bool trusted() const { return trusted_; }

  SORTIE_FIELDS(velocity_, taken_, late_cut_, late_left_, plain_, rest_, v_body_, stamp_ns_, known_, running_,
                trusted_, aided_)

 private:
  /// A blow that stops a fall is no outlier. What shortening has cut from the force comes back where the
  /// velocity explains the force better with it, in this block or with the next one: velocities come late.
  /// `left` is the force less gravity and the tracks' acceleration.
  VectorOf<Real> believed_cut(const VectorOf<Real>& left, const VectorOf<Real>& cut) {
    VectorOf<Real> believed{};
    const VectorOf<Real> both = late_left_ + left;
    if (closer_with(late_cut_, both)) believed = late_cut_;
    late_left_ = left;
    late_cut_ = cut;
    if (closer_with(cut, left + believed)) {
      believed = believed + cut;
      late_cut_ = {};
    }
    return believed;
  }
  static bool closer_with(const VectorOf<Real>& cut, const VectorOf<Real>& left) {
    return dot(cut + left, cut + left) < dot(left, left);
  }

  VectorOf<Real> velocity_;  // of the sensor, world, at the end of the block before
  VectorOf<Real> taken_;     // up to which velocity the mean force knows
  VectorOf<Real> late_cut_;  // of the block before, not yet believed
  VectorOf<Real> late_left_;
  VectorOf<Real> plain_;   // low-passed horizontal force
  VectorOf<Real> rest_;    // the same less the tracks' acceleration
  VectorOf<Real> v_body_;  // as told last
  rt::Nanoseconds stamp_ns_{};
  bool known_{};
  bool running_{};
  bool trusted_{true};
  bool aided_{};
};

}  // namespace sortie::estimators
