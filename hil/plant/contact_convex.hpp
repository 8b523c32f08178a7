// SPDX-License-Identifier: BSD-3-Clause
// A contact problem beside the true one that always has a minimum, and a way from its answer to the true one.
#pragma once

#include "hil/plant/contact_problem.hpp"

namespace sortie::hil {

/// Coulomb's law is no condition of a minimum: what a slipping contact's friction does needs no work of its
/// normal. With the cone's own projection in its place, as if the contact lifted by mu times its slip, it is
/// one; and with that lift taken back, as a number s of each contact that is kept while the minimum is
/// sought, the minimum obeys Coulomb's law where s = mu * slip (De Saxce and Feng 1998; Acary, Cadoux,
/// Lemarechal and Malick 2011). Each minimum is that of a strictly convex function of ten velocities,
///   1/2 u.M u - momentum.u + sum |P(-(J u - target + (approach + s) n))|^2 / 2R + servos,
/// P the nearest point in the cone, so Newton's method with a search along each step always gets there.
/// About 1.3 kB, and no heap.
class ConvexContacts {
 public:
  /// The lifts are those of the slips at `velocity`.
  ConvexContacts(const ContactProblem& problem, const Generalised& velocity);

  /// Takes at most `steps` steps towards the minimum from `velocity`, and fewer when the gradient is below
  /// `tolerance_ns`. Cost: 0.5 us a step and 0.15 us a contact and step.
  void descend(Generalised& velocity, int steps, double tolerance_ns) const;

  /// Writes the impulses that belong to the velocity.
  void write_impulses(ContactProblem& problem, const Generalised& velocity) const;

  /// Sets the lifts to those of the slips at `velocity`.
  void renew(const Generalised& velocity);

 private:
  /// What the law of the cone says of a contact: its impulse times R.
  struct Law {
    Vec3 push;  ///< m/s
    Grip grip{Grip::open};
    Vec3 along;       ///< slipping: direction of friction, unit
    double normal{};  ///< slipping: the push along the normal
    double side{};    ///< length of what friction would have to hold, m/s
  };
  Law law(std::uint32_t contact, const Generalised& velocity) const;
  Generalised gradient(const Generalised& velocity) const;
  ArrowMatrix curvature(const Generalised& velocity) const;
  double slope(const Generalised& velocity, double share, const Generalised& step) const;
  double share_of(const Generalised& velocity, const Generalised& step, double slope_at_start) const;

  const ContactProblem& problem_;
  double lift_m_s_[kMaxContacts];
};

}  // namespace sortie::hil
