// SPDX-License-Identifier: BSD-3-Clause
// The contact law, linearised at a velocity and the impulses that belong to it: what the solvers share.
#pragma once

#include "hil/plant/contact_problem.hpp"

namespace sortie::hil {

/// A contact's law asks: p = P(p - w / W), with w the violation of the law at a velocity and P the projection
/// onto Coulomb's cone (normal first, then the disc of radius mu times the new normal). `rho_kg` is 1 / W.
struct LawPoint {
  double normal_ns{};  ///< of p - rho w
  Vec3 side_ns;        ///< of p - rho w, in the tangent plane
  double side_length_ns{};
  double misfit_ns{};  ///< |p - P(p - rho w)|: the natural residual of this contact
};

/// Looks at one contact. Cost: 15 ns.
LawPoint look_at(const ContactPoint& contact, const Generalised& velocity, double compliance, double rho_kg);

/// What is left of all laws.
struct Misfit {
  double worst_ns{};
  double squares_n2s2{};  ///< sum

  void add(double misfit_ns) {
    if (misfit_ns > worst_ns || misfit_ns != misfit_ns) worst_ns = misfit_ns;
    squares_n2s2 += misfit_ns * misfit_ns;
  }
};

/// Reads every contact's grip from its law point, and each servo's; returns the misfits (servos' too, over
/// `gyration_m`). Writes grip, slip_direction, slip_rate into the contacts. Cost: 20 ns a contact.
Misfit classify(ContactProblem& problem, const Generalised& velocity, double rho_kg);

/// The linear system of the grips that classify() found (the generalised derivative of the projection, Alart
/// and Curnier 1991): matrix * velocity = rhs. A contact that sticks adds k J^T J, k = 1 / R; one that slips
/// adds k (n + mu z) n^T along the normal, where z is the friction's direction, and its slip_rate across.
/// Cost: 5 ns a contact that sticks, 40 ns one that slips.
void assemble(const ContactProblem& problem, ArrowMatrix& matrix, Generalised& rhs);

/// Impulses of the linear law at the velocity that solved the system: they keep the momentum exactly.
void take_impulses(ContactProblem& problem, const Generalised& velocity);

}  // namespace sortie::hil
