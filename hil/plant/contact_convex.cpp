// SPDX-License-Identifier: BSD-3-Clause
// Newton's method on a strictly convex function, and the lifts that lead to Coulomb's law.
#include "hil/plant/contact_convex.hpp"

#include <algorithm>
#include <cmath>

#include "hil/plant/contact_rows.hpp"

namespace sortie::hil {
namespace {

constexpr int kMostLooks = 12;       ///< along one step
constexpr double kWholeStep = 0.5;   ///< a whole step is taken when it leaves no more of the slope than this
constexpr double kGoodEnough = 0.1;  ///< and a part of it at this

double impulse_of(const JointDrive& drive, double speed_rad_s) {
  return std::clamp(free_impulse(drive, speed_rad_s), -drive.limit_nms, drive.limit_nms);
}

double largest(const Vec3& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

/// A momentum in N s.
double size_of(const Generalised& g, double gyration_m) {
  double size = std::max(largest(g.linear), largest(g.angular) / gyration_m);
  for (const double joint : g.joint) size = std::max(size, std::fabs(joint) / gyration_m);
  return size;
}

}  // namespace

ConvexContacts::ConvexContacts(const ContactProblem& problem, const Generalised& velocity)
    : problem_(problem) {
  for (std::uint32_t i = 0; i < problem_.contacts.size(); ++i) lift_m_s_[i] = 0.0;
  renew(velocity);
}

ConvexContacts::Law ConvexContacts::law(std::uint32_t contact, const Generalised& velocity) const {
  const ContactPoint& c = problem_.contacts[contact];
  const Vec3 v = velocity_at(c, velocity);
  const double along_normal = dot(c.normal, v);
  const double load = -(along_normal + c.approach_m_s + lift_m_s_[contact]);
  const Vec3 hold = c.target_m_s - v + along_normal * c.normal;  // targets lie in the tangent plane
  Law law;
  law.side = norm(hold);
  if (c.friction * law.side <= -load) return law;
  if (law.side <= c.friction * load) {
    law.grip = Grip::stick;
    law.push = load * c.normal + hold;
    return law;
  }
  law.grip = Grip::slip;
  law.normal = (load + c.friction * law.side) / (1.0 + c.friction * c.friction);
  if (law.side > 0.0) law.along = (1.0 / law.side) * hold;
  law.push = law.normal * (c.normal + c.friction * law.along);
  return law;
}

void ConvexContacts::renew(const Generalised& velocity) {
  for (std::uint32_t i = 0; i < problem_.contacts.size(); ++i) {
    const Law found = law(i, velocity);
    const double friction = problem_.contacts[i].friction;
    // What friction holds is no slip: the compliance's share of it.
    const double held = found.grip == Grip::slip ? friction * found.normal : 0.0;
    lift_m_s_[i] = found.grip == Grip::stick ? 0.0 : friction * (found.side - held);
  }
}

Generalised ConvexContacts::gradient(const Generalised& velocity) const {
  Generalised sum = multiply(problem_.mass, velocity) - problem_.momentum;
  const double k = 1.0 / problem_.compliance;
  for (std::uint32_t i = 0; i < problem_.contacts.size(); ++i) {
    const Law found = law(i, velocity);
    if (found.grip != Grip::open) add_impulse(problem_.contacts[i], -k * found.push, sum);
  }
  for (int j = 0; j < kFlippers; ++j) sum.joint[j] -= impulse_of(problem_.drives[j], velocity.joint[j]);
  return sum;
}

ArrowMatrix ConvexContacts::curvature(const Generalised& velocity) const {
  ArrowMatrix matrix = problem_.mass;
  const double k = 1.0 / problem_.compliance;
  StickSum stick;
  double a[7];
  double b[7];
  for (std::uint32_t i = 0; i < problem_.contacts.size(); ++i) {
    const ContactPoint& c = problem_.contacts[i];
    const Law found = law(i, velocity);
    if (found.grip == Grip::open) continue;
    if (found.grip == Grip::stick) {
      stick.add(c, k, matrix);
      continue;
    }
    const Vec3 pull = c.normal + c.friction * found.along;
    row_of(c, pull, k / (1.0 + c.friction * c.friction), a);
    row_of(c, pull, 1.0, b);
    add_product(matrix, c.joint, a, b);
    if (!(c.friction * found.side > 0.0)) continue;
    const Vec3 across = cross(c.normal, found.along);
    row_of(c, across, k * c.friction * found.normal / found.side, a);
    row_of(c, across, 1.0, b);
    add_product(matrix, c.joint, a, b);
  }
  stick.write(k, matrix);
  for (int j = 0; j < kFlippers; ++j) {
    const JointDrive& drive = problem_.drives[j];
    if (std::fabs(velocity.joint[j] + drive.bias_rad_s) <= drive.limit_nms * drive.compliance)
      matrix.diagonal[j] += 1.0 / drive.compliance;
  }
  return matrix;
}

double ConvexContacts::slope(const Generalised& velocity, double share, const Generalised& step) const {
  return dot(gradient(velocity + share * step), step);
}

// The slope along a step rises from below zero; where it is near zero is found between two ends by false
// position, the end that stays being trusted half as much each time.
double ConvexContacts::share_of(const Generalised& velocity, const Generalised& step,
                                double slope_at_start) const {
  double low = 0.0;
  double high = 1.0;
  double at_low = slope_at_start;
  double at_high = slope(velocity, 1.0, step);
  if (!(at_high > kWholeStep * std::fabs(slope_at_start))) return 1.0;
  double share = 1.0;
  for (int look = 0; look < kMostLooks; ++look) {
    share = (at_high * low - at_low * high) / (at_high - at_low);
    const double here = slope(velocity, share, step);
    if (std::fabs(here) < kGoodEnough * std::fabs(slope_at_start)) break;
    if (here < 0.0) {
      low = share;
      at_low = here;
      at_high *= 0.5;
    } else {
      high = share;
      at_high = here;
      at_low *= 0.5;
    }
  }
  return share;
}

void ConvexContacts::descend(Generalised& velocity, int steps, double tolerance_ns) const {
  for (int i = 0; i < steps; ++i) {
    const Generalised down = -1.0 * gradient(velocity);
    if (!(size_of(down, problem_.gyration_m) > tolerance_ns)) return;
    Generalised step;
    if (!solve(curvature(velocity), down, step)) return;
    velocity = velocity + share_of(velocity, step, -dot(down, step)) * step;
  }
}

void ConvexContacts::write_impulses(ContactProblem& problem, const Generalised& velocity) const {
  const double k = 1.0 / problem.compliance;
  for (std::uint32_t i = 0; i < problem.contacts.size(); ++i)
    problem.contacts[i].impulse_ns = k * law(i, velocity).push;
  for (int j = 0; j < kFlippers; ++j)
    problem.drives[j].impulse_nms = impulse_of(problem.drives[j], velocity.joint[j]);
}

}  // namespace sortie::hil
