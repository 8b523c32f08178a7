// SPDX-License-Identifier: BSD-3-Clause
// Coulomb's law with a little compliance, as projection and as linear system.
#include "hil/plant/contact_law.hpp"

#include <algorithm>
#include <cmath>

#include "hil/plant/contact_rows.hpp"

namespace sortie::hil {

LawPoint look_at(const ContactPoint& contact, const Generalised& velocity, double compliance, double rho_kg) {
  LawPoint point;
  const Vec3 v = velocity_at(contact, velocity);
  const double along = dot(contact.normal, v);
  const double load = dot(contact.normal, contact.impulse_ns);
  const Vec3 friction = contact.impulse_ns - load * contact.normal;
  const Vec3 slip = v - along * contact.normal - contact.target_m_s + compliance * friction;
  point.normal_ns = load - rho_kg * (along + contact.approach_m_s + compliance * load);
  point.side_ns = friction - rho_kg * slip;
  point.side_length_ns = norm(point.side_ns);
  const double projected = std::max(0.0, point.normal_ns);
  const double radius = contact.friction * projected;
  const double shrink = point.side_length_ns > radius ? radius / point.side_length_ns : 1.0;
  point.misfit_ns = std::max(std::fabs(projected - load), norm(shrink * point.side_ns - friction));
  return point;
}

Misfit classify(ContactProblem& problem, const Generalised& velocity, double rho_kg) {
  Misfit misfit;
  for (ContactPoint& c : problem.contacts) {
    const LawPoint point = look_at(c, velocity, problem.compliance, rho_kg);
    misfit.add(point.misfit_ns);
    const double radius = c.friction * point.normal_ns;
    if (!(point.normal_ns > 0.0)) {
      c.grip = Grip::open;
    } else if (point.side_length_ns <= radius && c.friction > 0.0) {
      c.grip = Grip::stick;
    } else {
      c.grip = Grip::slip;
      const double share = point.side_length_ns > 0.0 ? radius / point.side_length_ns : 0.0;
      c.slip_direction = point.side_length_ns > 0.0 ? (1.0 / point.side_length_ns) * point.side_ns : Vec3{};
      c.slip_rate = rho_kg * share / (1.0 - (1.0 - rho_kg * problem.compliance) * share);
    }
  }
  for (int j = 0; j < kFlippers; ++j) {
    JointDrive& drive = problem.drives[j];
    const double wanted = free_impulse(drive, velocity.joint[j]);
    drive.saturated = std::fabs(wanted) > drive.limit_nms;
    const double allowed = drive.saturated ? std::copysign(drive.limit_nms, wanted) : wanted;
    misfit.add(std::fabs(allowed - drive.impulse_nms) / problem.gyration_m);
    drive.edge_nms = allowed;
  }
  return misfit;
}

void assemble(const ContactProblem& problem, ArrowMatrix& matrix, Generalised& rhs) {
  matrix = problem.mass;
  rhs = problem.momentum;
  for (int j = 0; j < kFlippers; ++j) {
    const JointDrive& drive = problem.drives[j];
    if (drive.saturated) {
      rhs.joint[j] += drive.edge_nms;
    } else {
      matrix.diagonal[j] += 1.0 / drive.compliance;
      rhs.joint[j] -= drive.bias_rad_s / drive.compliance;
    }
  }
  const double k = 1.0 / problem.compliance;
  StickSum stick;
  double a[7];
  double b[7];
  for (const ContactPoint& c : problem.contacts) {
    if (c.grip == Grip::open) continue;
    if (c.grip == Grip::stick) {
      stick.add(c, k, matrix);
      add_impulse(c, k * (c.target_m_s - c.approach_m_s * c.normal), rhs);
      continue;
    }
    const Vec3 pull = c.normal + c.friction * c.slip_direction;
    row_of(c, pull, k, a);
    row_of(c, c.normal, 1.0, b);
    add_product(matrix, c.joint, a, b);
    Vec3 constant = (-k * c.approach_m_s) * pull;
    if (c.slip_rate > 0.0) {
      const Vec3 across = cross(c.normal, c.slip_direction);
      row_of(c, across, c.slip_rate, a);
      row_of(c, across, 1.0, b);
      add_product(matrix, c.joint, a, b);
      constant = constant + (c.slip_rate * dot(across, c.target_m_s)) * across;
    }
    add_impulse(c, constant, rhs);
  }
  stick.write(k, matrix);
}

void take_impulses(ContactProblem& problem, const Generalised& velocity) {
  const double k = 1.0 / problem.compliance;
  for (ContactPoint& c : problem.contacts) {
    if (c.grip == Grip::open) {
      c.impulse_ns = {};
      continue;
    }
    const Vec3 v = velocity_at(c, velocity);
    const double along = dot(c.normal, v);
    const double load = -k * (along + c.approach_m_s);
    if (c.grip == Grip::stick) {
      c.impulse_ns = load * c.normal - k * (v - along * c.normal - c.target_m_s);
    } else {
      const Vec3 across = cross(c.normal, c.slip_direction);
      c.impulse_ns = load * (c.normal + c.friction * c.slip_direction) -
                     (c.slip_rate * dot(across, v - c.target_m_s)) * across;
    }
  }
  for (int j = 0; j < kFlippers; ++j) {
    JointDrive& drive = problem.drives[j];
    drive.impulse_nms = drive.saturated ? drive.edge_nms : free_impulse(drive, velocity.joint[j]);
  }
}

}  // namespace sortie::hil
