// SPDX-License-Identifier: BSD-3-Clause
// From a path in time to attitude, turn rate and angular acceleration: a multirotor is flat in place and
// heading. What rotors that lag can follow exactly is a reference behind the same lag.
#pragma once

#include "rt/archive.hpp"
#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner {

/// Where to be, and how that changes; world frame.
struct FlatReference {
  rt::Vector3 p_m;
  rt::Vector3 v_m_s;
  rt::Vector3 a_m_s2;
  rt::Vector3 j_m_s3;
  rt::Vector3 s_m_s4;
  double yaw_rad{};
  double yaw_rate_rad_s{};
  double yaw_acceleration_rad_s2{};
  SORTIE_FIELDS(p_m, v_m_s, a_m_s2, j_m_s3, s_m_s4, yaw_rad, yaw_rate_rad_s, yaw_acceleration_rad_s2)
};

/// True when every number is finite.
inline bool is_finite(const FlatReference& r) {
  return rt::is_finite(r.p_m) && rt::is_finite(r.v_m_s) && rt::is_finite(r.a_m_s2) &&
         rt::is_finite(r.j_m_s3) && rt::is_finite(r.s_m_s4) && std::isfinite(r.yaw_rad) &&
         std::isfinite(r.yaw_rate_rad_s) && std::isfinite(r.yaw_acceleration_rad_s2);
}

/// The body that follows: axes in the world, rates and accelerations in those axes.
struct FlatBody {
  rt::Vector3 x, y, z;   ///< axes of the body
  double thrust_m_s2{};  ///< collective acceleration along z
  double thrust_rate_m_s3{};
  rt::Vector3 w_rad_s;
  rt::Vector3 alpha_rad_s2;
};

/// Differential flatness (Mellinger and Kumar 2011). `force_m_s2` is the specific force to be made: wanted
/// acceleration plus gravity minus what the air does. Longer than 0 and not along `heading` (cosine and sine
/// of the yaw).
inline FlatBody flat_body(const rt::Vector3& force_m_s2, const FlatReference& r, const rt::SinCos& heading) {
  using rt::cross;
  using rt::dot;
  FlatBody body;
  body.thrust_m_s2 = rt::norm(force_m_s2);
  const double per_thrust = 1.0 / body.thrust_m_s2;
  body.z = per_thrust * force_m_s2;
  const rt::Vector3 side = cross(body.z, rt::Vector3{heading.cos, heading.sin, 0.0});
  body.y = (1.0 / rt::norm(side)) * side;
  body.x = cross(body.y, body.z);
  body.thrust_rate_m_s3 = dot(body.z, r.j_m_s3);
  // b3' = (j - (b3 . j) b3) / c = w x b3; its parts along x and y are w_y and -w_x.
  body.w_rad_s = {-per_thrust * dot(body.y, r.j_m_s3), per_thrust * dot(body.x, r.j_m_s3),
                  r.yaw_rate_rad_s * body.z.z};
  // c b3'' = s - c'' b3 - 2 c' b3', with the centripetal part of b3'' going into the coupling with w_z.
  const double twice = 2.0 * per_thrust * body.thrust_rate_m_s3;
  const rt::Vector3& w = body.w_rad_s;
  body.alpha_rad_s2 = {-per_thrust * dot(body.y, r.s_m_s4) - twice * w.x + w.y * w.z,
                       per_thrust * dot(body.x, r.s_m_s4) - twice * w.y - w.x * w.z,
                       r.yaw_acceleration_rad_s2 * body.z.z};
  return body;
}

/// A smooth motion, passed through the first-order lag of the rotors. Its derivatives then belong to
/// accelerations that rotors can make, and the command that makes them is the snap of the motion before the
/// lag: the chain of integrators behind the lag is fed forward without a derivative of the snap. The result
/// comes `tau_s` later. 60 bytes, no heap, 20 operations.
class ReferenceLag {
 public:
  ReferenceLag(double tau_s, double period_s) : tau_s_(tau_s), keep_(rt::exp(-period_s / tau_s)) {}

  void reset() { snap_ = lead_ = {}; }

  /// The motion at the start of a period and its snap, constant over the period, to the reference there.
  FlatReference step(const FlatReference& start, const rt::Vector3& snap_m_s4) {
    FlatReference r = start;
    r.s_m_s4 = snap_;
    r.j_m_s3 = start.j_m_s3 - tau_s_ * r.s_m_s4;  // y = x - tau y' is what a lag does to each derivative
    r.a_m_s2 = start.a_m_s2 - tau_s_ * r.j_m_s3;
    r.v_m_s = start.v_m_s - tau_s_ * r.a_m_s2;
    r.p_m = start.p_m - tau_s_ * r.v_m_s;
    lead_ = snap_m_s4 - snap_;
    snap_ = snap_m_s4 + keep_ * (snap_ - snap_m_s4);
    return r;
  }

  /// The motion whose lagged reference `r` is, for one that begins within a motion.
  FlatReference ahead(const FlatReference& r) const {
    FlatReference x = r;
    x.p_m = r.p_m + tau_s_ * r.v_m_s;
    x.v_m_s = r.v_m_s + tau_s_ * r.a_m_s2;
    x.a_m_s2 = r.a_m_s2 + tau_s_ * r.j_m_s3;
    return x;
  }

  /// What the snap of the command has more than that of the reference, over the period that step() began.
  const rt::Vector3& lead_m_s4() const { return lead_; }

  /// State to bytes and back.
  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "reference lag").fixed(tau_s_, keep_).state(snap_, lead_);
  }

 private:
  double tau_s_;
  double keep_;
  rt::Vector3 snap_;
  rt::Vector3 lead_;
};

}  // namespace sortie::planner
