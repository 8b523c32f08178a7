// SPDX-License-Identifier: BSD-3-Clause
// One step's contact problem, as the production solver and the reference solver both get it.
//
// Unknown: the velocity u after the step (ten degrees of freedom, body axes) and an impulse p at each
// contact, with
//   M u = momentum + sum J^T p + joint impulses,                                  (momentum)
//   0 <= p_n  _|_  n.(J u) + R p_n + approach >= 0,                               (no penetration)
//   |p_t| <= mu p_n, p_t = -(J u - target)_t / R inside the cone, else on its edge against the slip.
//   (Coulomb)
// Equations 1-4 of the contact-surface-motion paper, with J^T and the factor p_n that its print lost, in
// velocities (Stewart and Trinkle 1996), without restitution. R is the compliance of a contact: a damper so
// stiff that its creep is below 1e-5 m/s for the vehicle's weight, which makes the load of many contacts
// under one rigid body unique: the one of least squares, so the same for every solver and order.
#pragma once

#include <cstdint>

#include "hil/plant/generalised.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::hil {

/// What a contact does.
enum class Grip : std::uint8_t { open, stick, slip };

/// A contact in body axes. 230 bytes.
struct ContactPoint {
  Vec3 point_m;           ///< from the body's origin
  Vec3 normal;            ///< unit, out of the obstacle into the vehicle
  Vec3 target_m_s;        ///< what friction pulls the vehicle's velocity here to, in the tangent plane
  double approach_m_s{};  ///< speed along -normal that is free until the gap closes; negative pushes apart
  double friction{};      ///< mu
  int joint{-1};          ///< flipper that is touched, or -1
  Vec3 lever_m;           ///< velocity of the point per rad/s of that joint
  Vec3 impulse_ns;        ///< on the vehicle. In: a guess, such as that of the step before; out: the answer
  Grip grip{Grip::open};  ///< out
  Vec3 slip_direction;    ///< out, of a slipping contact: of its friction, unit
  double slip_rate{};     ///< out, the same: growth of friction per speed across it, N s per m/s
};

/// A flipper's servo in one step, implicit: impulse = clamp(-(speed + bias) / compliance, +-limit).
struct JointDrive {
  double compliance{1.0};  ///< rad/s per N m s
  double bias_rad_s{};
  double limit_nms{};
  double impulse_nms{};  ///< out
  bool saturated{};      ///< out
  double edge_nms{};     ///< out, of a saturated one: the limit that it is at, with its sign
};

constexpr std::uint32_t kMaxContacts = 160;
using ContactList = rt::FixedVector<ContactPoint, kMaxContacts>;

/// The problem. About 38 kB.
struct ContactProblem {
  ArrowMatrix mass;
  Generalised momentum;  ///< before contacts: M u_before + forces * dt
  JointDrive drives[kFlippers];
  double compliance{};  ///< R, m/s per N s
  double gyration_m{};  ///< a length that turns N m s into N s in residuals
  ContactList contacts;
};

/// What a servo would give if it had no limit.
inline double free_impulse(const JointDrive& drive, double speed_rad_s) {
  return -(speed_rad_s + drive.bias_rad_s) / drive.compliance;
}

/// Velocity of the vehicle at a contact.
inline Vec3 velocity_at(const ContactPoint& c, const Generalised& u) {
  const Vec3 v = u.linear + cross(u.angular, c.point_m);
  return c.joint < 0 ? v : v + u.joint[c.joint] * c.lever_m;
}

/// Adds J^T p.
inline void add_impulse(const ContactPoint& c, const Vec3& p, Generalised& sum) {
  sum.linear = sum.linear + p;
  sum.angular = sum.angular + cross(c.point_m, p);
  if (c.joint >= 0) sum.joint[c.joint] += dot(c.lever_m, p);
}

}  // namespace sortie::hil
