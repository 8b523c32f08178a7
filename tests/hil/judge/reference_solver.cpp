// SPDX-License-Identifier: BSD-3-Clause
// Contact problems over impulses, dense: sweeps that always approach, Newton steps that end it.
#include "tests/hil/judge/reference_solver.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "tests/hil/judge/natural_residual.hpp"

namespace sortie::hil {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Contacts as rows: normal and two tangents each, in world-independent body axes.
struct Dense {
  Matrix jacobian;       ///< 3n x 10
  Matrix inverse_mass;   ///< 10 x 10, servos included as far as they are not saturated
  Vector free_velocity;  ///< without contacts
  Matrix delassus;       ///< with compliance on its diagonal
  Vector offset;         ///< J u_free + (approach, -target, -target)
  Vector step;           ///< one over the diagonal, the same for both tangents
  Vector friction;
};

Vector to_vector(const Generalised& g) {
  Vector v(10);
  v << g.linear.x, g.linear.y, g.linear.z, g.angular.x, g.angular.y, g.angular.z, g.joint[0], g.joint[1],
      g.joint[2], g.joint[3];
  return v;
}

Dense build(const ContactProblem& problem) {
  const auto n = static_cast<Eigen::Index>(problem.contacts.size());
  Dense d;
  Matrix mass = Matrix::Zero(10, 10);
  Vector momentum = to_vector(problem.momentum);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) mass(i, j) = problem.mass.base[i][j];
  }
  for (int j = 0; j < kFlippers; ++j) {
    const JointDrive& drive = problem.drives[j];
    for (int i = 0; i < 6; ++i) mass(i, 6 + j) = mass(6 + j, i) = problem.mass.column[j][i];
    mass(6 + j, 6 + j) = problem.mass.diagonal[j] + (drive.saturated ? 0.0 : 1.0 / drive.compliance);
    momentum(6 + j) += drive.saturated ? drive.impulse_nms : -drive.bias_rad_s / drive.compliance;
  }
  d.inverse_mass = mass.ldlt().solve(Matrix::Identity(10, 10));
  d.free_velocity = d.inverse_mass * momentum;
  d.jacobian = Matrix::Zero(3 * n, 10);
  d.offset = Vector::Zero(3 * n);
  d.friction = Vector::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ContactPoint& c = problem.contacts[static_cast<std::uint32_t>(i)];
    const Eigen::Vector3d normal(c.normal.x, c.normal.y, c.normal.z);
    const Eigen::Vector3d first = normal.unitOrthogonal();
    const Eigen::Vector3d axes[3] = {normal, first, normal.cross(first)};
    const Eigen::Vector3d point(c.point_m.x, c.point_m.y, c.point_m.z);
    const Eigen::Vector3d lever(c.lever_m.x, c.lever_m.y, c.lever_m.z);
    const Eigen::Vector3d target(c.target_m_s.x, c.target_m_s.y, c.target_m_s.z);
    for (int k = 0; k < 3; ++k) {
      d.jacobian.block<1, 3>(3 * i + k, 0) = axes[k].transpose();
      d.jacobian.block<1, 3>(3 * i + k, 3) = point.cross(axes[k]).transpose();
      if (c.joint >= 0) d.jacobian(3 * i + k, 6 + c.joint) = axes[k].dot(lever);
      d.offset(3 * i + k) = k == 0 ? c.approach_m_s : -axes[k].dot(target);
    }
    d.friction(i) = c.friction;
  }
  d.offset += d.jacobian * d.free_velocity;
  d.delassus = d.jacobian * d.inverse_mass * d.jacobian.transpose();
  d.delassus.diagonal().array() += problem.compliance;
  d.step = d.delassus.diagonal().cwiseInverse();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double both = 1.0 / (d.delassus(3 * i + 1, 3 * i + 1) + d.delassus(3 * i + 2, 3 * i + 2));
    d.step(3 * i + 1) = d.step(3 * i + 2) = both;
  }
  return d;
}

/// p - P(p - step w), and its derivative where asked for.
Vector natural_map(const Dense& d, const Vector& p, Matrix* derivative) {
  const Vector w = d.delassus * p + d.offset;
  Vector map = p;
  if (derivative != nullptr) *derivative = Matrix::Identity(p.size(), p.size());
  for (Eigen::Index i = 0; i < d.friction.size(); ++i) {
    const double load = p(3 * i) - d.step(3 * i) * w(3 * i);
    if (load <= 0.0) continue;  // projected to zero, so the map is p itself
    const Eigen::Vector2d side = p.segment<2>(3 * i + 1) - d.step(3 * i + 1) * w.segment<2>(3 * i + 1);
    const double radius = d.friction(i) * load;
    const double length = side.norm();
    const bool inside = length <= radius;
    map(3 * i) -= load;
    map.segment<2>(3 * i + 1) -= inside ? side : Eigen::Vector2d(side * (radius / length));
    if (derivative == nullptr) continue;
    Matrix moved = -d.step(3 * i) * d.delassus.middleRows(3 * i, 1);
    moved(0, 3 * i) += 1.0;
    Matrix turned = -d.step(3 * i + 1) * d.delassus.middleRows(3 * i + 1, 2);
    turned.block<2, 2>(0, 3 * i + 1) += Eigen::Matrix2d::Identity();
    derivative->middleRows(3 * i, 1) -= moved;
    if (inside) {
      derivative->middleRows(3 * i + 1, 2) -= turned;
    } else {
      const Eigen::Vector2d z = side / length;
      const Eigen::Matrix2d across = (radius / length) * (Eigen::Matrix2d::Identity() - z * z.transpose());
      derivative->middleRows(3 * i + 1, 2) -= d.friction(i) * z * moved + across * turned;
    }
  }
  return map;
}

void sweep(const Dense& d, Vector& p) {
  for (Eigen::Index i = 0; i < d.friction.size(); ++i) {
    p(3 * i) = std::max(0.0, p(3 * i) - d.step(3 * i) * (d.delassus.row(3 * i).dot(p) + d.offset(3 * i)));
    Eigen::Vector2d side;
    for (int k = 1; k < 3; ++k) {
      side(k - 1) =
          p(3 * i + k) - d.step(3 * i + k) * (d.delassus.row(3 * i + k).dot(p) + d.offset(3 * i + k));
    }
    const double radius = d.friction(i) * p(3 * i);
    const double length = side.norm();
    if (length > radius) side *= radius / length;
    p.segment<2>(3 * i + 1) = side;
  }
}

/// Damped Newton: each step must shrink the map.
void polish(const Dense& d, Vector& p, double tolerance, ReferenceReport& report) {
  Matrix derivative;
  Vector map = natural_map(d, p, &derivative);
  for (int i = 0; i < 60 && map.lpNorm<Eigen::Infinity>() > tolerance; ++i) {
    const Vector direction = derivative.fullPivLu().solve(map);
    double share = 1.0;
    Vector next = p - direction;
    while (share > 1e-6 && !(natural_map(d, next, nullptr).norm() < (1.0 - 1e-4 * share) * map.norm())) {
      share *= 0.5;
      next = p - share * direction;
    }
    if (share <= 1e-6) return;
    ++report.newton_steps;
    p = next;
    map = natural_map(d, p, &derivative);
  }
}

/// The impulses in the problem, along the rows of build().
Vector guess_of(const ContactProblem& problem) {
  Vector p(3 * static_cast<Eigen::Index>(problem.contacts.size()));
  for (std::uint32_t i = 0; i < problem.contacts.size(); ++i) {
    const ContactPoint& c = problem.contacts[i];
    const Eigen::Vector3d normal(c.normal.x, c.normal.y, c.normal.z);
    const Eigen::Vector3d first = normal.unitOrthogonal();
    const Eigen::Vector3d impulse(c.impulse_ns.x, c.impulse_ns.y, c.impulse_ns.z);
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(i);
    p(row) = normal.dot(impulse);
    p(row + 1) = first.dot(impulse);
    p(row + 2) = normal.cross(first).dot(impulse);
  }
  return p;
}

}  // namespace

ReferenceReport solve_reference(ContactProblem& problem, Generalised& velocity, double tolerance_ns,
                                int sweep_limit) {
  ReferenceReport report;
  for (JointDrive& drive : problem.drives) drive.saturated = false;
  Vector p = guess_of(problem);
  for (int servo_round = 0; servo_round < 16; ++servo_round) {
    const Dense d = build(problem);
    Vector first = p;
    polish(d, first, 0.1 * tolerance_ns, report);
    if (natural_map(d, first, nullptr).lpNorm<Eigen::Infinity>() <= 0.1 * tolerance_ns) p = first;
    int block = 100;
    while (natural_map(d, p, nullptr).lpNorm<Eigen::Infinity>() > 0.1 * tolerance_ns &&
           report.sweeps < sweep_limit) {
      for (int i = 0; i < block; ++i) sweep(d, p);
      report.sweeps += block;
      block = std::min(2 * block, 5000);
      Vector polished = p;
      polish(d, polished, 0.1 * tolerance_ns, report);
      if (natural_map(d, polished, nullptr).norm() < 0.1 * natural_map(d, p, nullptr).norm()) p = polished;
    }
    const Vector u = d.free_velocity + d.inverse_mass * d.jacobian.transpose() * p;
    velocity = {{u(0), u(1), u(2)}, {u(3), u(4), u(5)}, {u(6), u(7), u(8), u(9)}};
    bool changed = false;
    for (int j = 0; j < kFlippers; ++j) {
      JointDrive& drive = problem.drives[j];
      const double wanted = -(velocity.joint[j] + drive.bias_rad_s) / drive.compliance;
      const bool saturated = std::fabs(wanted) > drive.limit_nms;
      const double impulse = saturated ? std::copysign(drive.limit_nms, wanted) : wanted;
      changed = changed || saturated != drive.saturated || (saturated && impulse != drive.impulse_nms);
      drive.saturated = saturated;
      drive.impulse_nms = impulse;
    }
    if (!changed) break;
  }
  for (std::uint32_t i = 0; i < problem.contacts.size(); ++i) {
    ContactPoint& c = problem.contacts[i];
    const Eigen::Vector3d normal(c.normal.x, c.normal.y, c.normal.z);
    const Eigen::Vector3d first = normal.unitOrthogonal();
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(i);
    const Eigen::Vector3d sum = p(row) * normal + p(row + 1) * first + p(row + 2) * normal.cross(first);
    c.impulse_ns = {sum.x(), sum.y(), sum.z()};
  }
  report.residual_ns = natural_residual(problem, problem.compliance);
  return report;
}

}  // namespace sortie::hil
