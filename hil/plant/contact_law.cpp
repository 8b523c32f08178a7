// SPDX-License-Identifier: BSD-3-Clause
// Coulomb's law with a little compliance, as projection and as linear system.
#include "hil/plant/contact_law.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::hil {
namespace {

/// matrix += a b^T, a and b as six base numbers and one of the joint.
void add_product(ArrowMatrix& matrix, int joint, const double (&a)[7], const double (&b)[7]) {
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) matrix.base[r][c] += a[r] * b[c];
  }
  if (joint < 0) return;
  for (int r = 0; r < 6; ++r) {
    matrix.column[joint][r] += a[r] * b[6];
    matrix.row[joint][r] += a[6] * b[r];
  }
  matrix.diagonal[joint] += a[6] * b[6];
}

/// factor * J^T d of a direction.
void row_of(const ContactPoint& c, const Vec3& d, double factor, double (&out)[7]) {
  const Vec3 turn = cross(c.point_m, d);
  out[0] = factor * d.x;
  out[1] = factor * d.y;
  out[2] = factor * d.z;
  out[3] = factor * turn.x;
  out[4] = factor * turn.y;
  out[5] = factor * turn.z;
  out[6] = factor * dot(c.lever_m, d);
}

/// Sum over sticking contacts of k J^T J: the same stiffness k in all directions needs no contact frame.
struct StickSum {
  double count{};
  Vec3 first;
  double xx{}, yy{}, zz{}, xy{}, xz{}, yz{};

  void add(const Vec3& p) {
    count += 1.0;
    first = first + p;
    xx += p.x * p.x;
    yy += p.y * p.y;
    zz += p.z * p.z;
    xy += p.x * p.y;
    xz += p.x * p.z;
    yz += p.y * p.z;
  }

  void write(double k, ArrowMatrix& matrix) const {
    double(&b)[6][6] = matrix.base;
    for (int i = 0; i < 3; ++i) b[i][i] += k * count;
    const Vec3 s = k * first;
    const double skew[3][3] = {{0.0, -s.z, s.y}, {s.z, 0.0, -s.x}, {-s.y, s.x, 0.0}};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        b[3 + i][j] += skew[i][j];
        b[i][3 + j] += skew[j][i];
      }
    }
    b[3][3] += k * (yy + zz);
    b[4][4] += k * (xx + zz);
    b[5][5] += k * (xx + yy);
    b[3][4] -= k * xy;
    b[4][3] -= k * xy;
    b[3][5] -= k * xz;
    b[5][3] -= k * xz;
    b[4][5] -= k * yz;
    b[5][4] -= k * yz;
  }
};

double drive_impulse(const JointDrive& drive, double speed_rad_s) {
  return -(speed_rad_s + drive.bias_rad_s) / drive.compliance;
}

}  // namespace

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

double classify(ContactProblem& problem, const Generalised& velocity, double rho_kg) {
  double worst = 0.0;
  for (ContactPoint& c : problem.contacts) {
    const LawPoint point = look_at(c, velocity, problem.compliance, rho_kg);
    worst = std::max(worst, point.misfit_ns);
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
    const double wanted = drive_impulse(drive, velocity.joint[j]);
    drive.saturated = std::fabs(wanted) > drive.limit_nms;
    const double allowed = drive.saturated ? std::copysign(drive.limit_nms, wanted) : wanted;
    worst = std::max(worst, std::fabs(allowed - drive.impulse_nms) / problem.gyration_m);
    drive.edge_nms = allowed;
  }
  return worst;
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
      stick.add(c.point_m);
      if (c.joint >= 0) {
        row_of(c, c.lever_m, k, a);
        for (int r = 0; r < 6; ++r) {
          matrix.column[c.joint][r] += a[r];
          matrix.row[c.joint][r] += a[r];
        }
        matrix.diagonal[c.joint] += a[6];
      }
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
    drive.impulse_nms = drive.saturated ? drive.edge_nms : drive_impulse(drive, velocity.joint[j]);
  }
}

}  // namespace sortie::hil
