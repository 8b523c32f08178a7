// SPDX-License-Identifier: BSD-3-Clause
// How far an answer is from the contact law, judged from its impulses alone.
#pragma once

#include <algorithm>
#include <cmath>

#include "hil/plant/contact_law.hpp"

namespace sortie::hil {

/// The natural residual of an answer, N s: with u from the momentum equation for the impulses given, the
/// largest |p - P(p - w / W)| over the contacts, where P projects onto the cone as look_at() does and w is
/// the violation with compliance `problem.compliance` (0 asks for the rigid law) and W the contact's own
/// inverse mass. Negative when the mass matrix is singular.
inline double natural_residual(const ContactProblem& problem, double compliance) {
  Generalised momentum = problem.momentum;
  for (const ContactPoint& c : problem.contacts) add_impulse(c, c.impulse_ns, momentum);
  for (int j = 0; j < kFlippers; ++j) momentum.joint[j] += problem.drives[j].impulse_nms;
  Generalised u;
  if (!solve(problem.mass, momentum, u)) return -1.0;
  double worst = 0.0;
  for (const ContactPoint& c : problem.contacts) {
    Generalised push;
    Generalised response;
    add_impulse(c, c.normal, push);
    if (!solve(problem.mass, push, response)) return -1.0;
    const double own = dot(c.normal, velocity_at(c, response)) + compliance;
    worst = std::max(worst, look_at(c, u, compliance, 1.0 / own).misfit_ns);
  }
  for (int j = 0; j < kFlippers; ++j) {
    // A servo's impulse changes the speed of its own joint; its law is met where this correction is zero.
    const JointDrive& drive = problem.drives[j];
    const double stiff = problem.mass.diagonal[j];
    const double wanted = -(u.joint[j] + drive.bias_rad_s) / drive.compliance;
    const double share =
        1.0 / (1.0 + 1.0 / (stiff * drive.compliance));  // the servo's inertia beside the joint's
    const double next = drive.impulse_nms + share * (wanted - drive.impulse_nms);
    const double allowed = std::clamp(next, -drive.limit_nms, drive.limit_nms);
    worst = std::max(worst, std::fabs(allowed - drive.impulse_nms) / problem.gyration_m);
  }
  return worst;
}

}  // namespace sortie::hil
