// SPDX-License-Identifier: BSD-3-Clause
// One contact after the other is brought to its law, the velocity follows at once.
#include <algorithm>
#include <cmath>

#include "hil/plant/contact_solver.hpp"

namespace sortie::hil {
namespace {

/// What an impulse at a contact does to the velocity, along the normal and two tangents.
struct Response {
  Vec3 tangent[2];
  Generalised per_impulse[3];
  double normal_mass_kg;  ///< inverse of the contact's own inverse mass along the normal, compliance included
  double tangent_mass_kg;  ///< the same for the stiffer tangent
};

bool respond(const ArrowMatrix& mass, const ContactPoint& c, double compliance, Response& out) {
  const Vec3 other = std::fabs(c.normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 raw = cross(c.normal, other);
  out.tangent[0] = (1.0 / norm(raw)) * raw;
  out.tangent[1] = cross(c.normal, out.tangent[0]);
  const Vec3 directions[3] = {c.normal, out.tangent[0], out.tangent[1]};
  Vec3 speed[3];
  for (int i = 0; i < 3; ++i) {
    Generalised push;
    add_impulse(c, directions[i], push);
    if (!solve(mass, push, out.per_impulse[i])) return false;
    speed[i] = velocity_at(c, out.per_impulse[i]);
  }
  const double first = dot(directions[1], speed[1]);
  const double second = dot(directions[2], speed[2]);
  const double mixed = dot(directions[2], speed[1]);
  const double difference = first - second;
  const double largest = 0.5 * (first + second + std::sqrt(difference * difference + 4.0 * mixed * mixed));
  out.normal_mass_kg = 1.0 / (dot(c.normal, speed[0]) + compliance);
  out.tangent_mass_kg = 1.0 / (largest + compliance);
  return true;
}

/// Normal, then friction, of one contact.
void relax(ContactPoint& c, const Response& r, double compliance, Generalised& u) {
  const double load = dot(c.normal, c.impulse_ns);
  const Vec3 friction = c.impulse_ns - load * c.normal;
  const double gap_speed = dot(c.normal, velocity_at(c, u)) + c.approach_m_s + compliance * load;
  const double new_load = std::max(0.0, load - r.normal_mass_kg * gap_speed);
  u = u + (new_load - load) * r.per_impulse[0];
  const Vec3 slip = velocity_at(c, u) - c.target_m_s + compliance * friction;
  double first = dot(r.tangent[0], friction) - r.tangent_mass_kg * dot(r.tangent[0], slip);
  double second = dot(r.tangent[1], friction) - r.tangent_mass_kg * dot(r.tangent[1], slip);
  const double length = std::sqrt(first * first + second * second);
  const double radius = c.friction * new_load;
  if (length > radius) {
    first *= radius / length;
    second *= radius / length;
  }
  const Vec3 new_friction = first * r.tangent[0] + second * r.tangent[1];
  const Vec3 change = new_friction - friction;
  u = u + dot(r.tangent[0], change) * r.per_impulse[1] + dot(r.tangent[1], change) * r.per_impulse[2];
  c.impulse_ns = new_load * c.normal + new_friction;
}

/// A servo, like a contact: its impulse within its limits.
void relax(JointDrive& drive, int joint, const Generalised& response, Generalised& u) {
  const double violation = u.joint[joint] + drive.bias_rad_s + drive.compliance * drive.impulse_nms;
  const double wanted = drive.impulse_nms - violation / (response.joint[joint] + drive.compliance);
  const double impulse = std::clamp(wanted, -drive.limit_nms, drive.limit_nms);
  u = u + (impulse - drive.impulse_nms) * response;
  drive.impulse_nms = impulse;
}

}  // namespace

bool sweep_contacts(ContactProblem& problem, Generalised& velocity, int count) {
  Response responses[kMaxContacts];
  Generalised joint_responses[kFlippers];
  Generalised momentum = problem.momentum;
  const std::uint32_t size = problem.contacts.size();
  for (std::uint32_t i = 0; i < size; ++i) {
    ContactPoint& c = problem.contacts[i];
    if (!respond(problem.mass, c, problem.compliance, responses[i])) return false;
    add_impulse(c, c.impulse_ns, momentum);
  }
  for (int j = 0; j < kFlippers; ++j) {
    Generalised push;
    push.joint[j] = 1.0;
    if (!solve(problem.mass, push, joint_responses[j])) return false;
    momentum.joint[j] += problem.drives[j].impulse_nms;
  }
  if (!solve(problem.mass, momentum, velocity)) return false;
  for (int sweep = 0; sweep < count; ++sweep) {
    for (std::uint32_t k = 0; k < size; ++k) {
      const std::uint32_t i = sweep % 2 == 0 ? k : size - 1 - k;
      relax(problem.contacts[i], responses[i], problem.compliance, velocity);
    }
    for (int j = 0; j < kFlippers; ++j) relax(problem.drives[j], j, joint_responses[j], velocity);
  }
  return true;
}

}  // namespace sortie::hil
