// SPDX-License-Identifier: BSD-3-Clause
// From velocities to the next configuration: correction, integration, momentum carried over, energy.
#include <algorithm>
#include <cmath>

#include "hil/plant/tracked_plant.hpp"

namespace sortie::hil {
namespace {

constexpr double kFastest_m_s = 200.0;  ///< beyond these a state is refused
constexpr double kFastest_rad_s = 2000.0;

bool usable(const Generalised& u) {
  bool good = dot(u.linear, u.linear) < kFastest_m_s * kFastest_m_s &&
              dot(u.angular, u.angular) < kFastest_rad_s * kFastest_rad_s;
  for (const double rate : u.joint) good = good && std::fabs(rate) < kFastest_rad_s;
  return good;  // false for NaN too
}

/// Energy of a servo's spring, which ends at its torque limit.
double spring_energy(double stretch_rad, const VehicleConfig& c) {
  const double linear = c.servo_torque_nm / c.servo_stiffness_nm_rad;
  const double s = std::fabs(stretch_rad);
  return s <= linear ? 0.5 * c.servo_stiffness_nm_rad * s * s : c.servo_torque_nm * (s - 0.5 * linear);
}

}  // namespace

Generalised TrackedPlant::correct(double dt_s) {
  for (const ContactTag& tag : finder_.tags())
    report_.penetration_m = std::max(report_.penetration_m, -tag.gap_m);
  Generalised push;
  if (report_.penetration_m <= config_.slop_m) return push;
  // A velocity beside the real one, for one step, without friction: depths shrink, open contacts stay open
  // where the real velocity leaves them, the flippers keep their angles. It adds no kinetic energy.
  correction_.mass = mass_.matrix;
  correction_.momentum = {};
  correction_.compliance = problem_.compliance;
  correction_.gyration_m = problem_.gyration_m;
  for (int f = 0; f < kFlippers; ++f) {
    correction_.drives[f] = {1e-6 / mass_.matrix.diagonal[f], 0.0, 1e300, 0.0, false};
  }
  correction_.contacts = problem_.contacts;
  for (std::uint32_t i = 0; i < correction_.contacts.size(); ++i) {
    ContactPoint& c = correction_.contacts[i];
    const double gap = finder_.tags()[i].gap_m;
    const double deep = -gap - config_.slop_m;
    const double left = gap / dt_s + dot(c.normal, velocity_at(c, state_.velocity));
    c.friction = 0.0;
    c.target_m_s = {};
    c.approach_m_s = deep > 0.0
                         ? -std::min(config_.correction_rate * deep / dt_s, config_.correction_speed_m_s)
                         : std::max(0.0, left);
    c.impulse_ns = {};
  }
  SolverOptions options;
  options.newton_iterations = config_.newton_iterations;
  options.tolerance_ns = 1e-6 * model_.mass_kg() * config_.correction_speed_m_s;
  solver_(correction_, push, options);
  return usable(push) ? push : Generalised{};
}

void TrackedPlant::integrate(const Generalised& correction, const PlantCommand& command, double dt_s) {
  if (!usable(state_.velocity)) {
    state_.velocity = {};
    ++counters_.rejected;
  }
  const Generalised momentum = multiply(mass_.matrix, state_.velocity);
  const Generalised moved = state_.velocity + correction;
  // What the correction does to the potential energy: lift of the centre of mass, and the springs' stretch.
  const Vec3 lift = R_world_body_ * multiply(mass_.matrix, correction).linear;
  report_.correction_j = config_.gravity_m_s2 * dt_s * lift.z;
  for (int f = 0; f < kFlippers; ++f) {
    const double stretch =
        state_.flipper_set_rad[f] - state_.flipper_rad[f] - dt_s * state_.velocity.joint[f];
    report_.correction_j += spring_energy(stretch - dt_s * correction.joint[f], config_.vehicle) -
                            spring_energy(stretch, config_.vehicle);
  }
  const Vec3 com_speed = (1.0 / mass_.mass_kg) * multiply(mass_.matrix, moved).linear;
  state_.com_world_m = state_.com_world_m + dt_s * (R_world_body_ * com_speed);
  const Quat turned = exp_rotation(dt_s * moved.angular);
  state_.q_world_body = normalized(state_.q_world_body * turned);
  for (int f = 0; f < kFlippers; ++f) state_.flipper_rad[f] += dt_s * moved.joint[f];
  state_.left_m += dt_s * command.left_m_s;
  state_.right_m += dt_s * command.right_m_s;
  carry_momentum(momentum, turned, dt_s);
  R_world_body_ = to_matrix(state_.q_world_body);
  p_world_body_m_ = state_.com_world_m - R_world_body_ * mass_.com_m;
}

void TrackedPlant::carry_momentum(const Generalised& momentum, const Quat& turned, double dt_s) {
  // Momentum of the world stays: in the axes that turned on it turns back. Flippers feel dT/dq beside.
  const Quat back_turn = conjugate(turned);
  const double mass = mass_.mass_kg;
  const Vec3 about_com = momentum.angular - cross(mass_.com_m, momentum.linear);
  const double turning = dot(state_.velocity, momentum) - dot(momentum.linear, momentum.linear) / mass;
  double force_nm[kFlippers];
  model_.joint_motion_force(mass_, state_.velocity, force_nm);
  model_.mass_at(state_.flipper_rad, mass_);
  Generalised next;
  next.linear = rotate(back_turn, momentum.linear);
  next.angular = rotate(back_turn, about_com) + cross(mass_.com_m, next.linear);
  for (int f = 0; f < kFlippers; ++f) next.joint[f] = momentum.joint[f] + dt_s * force_nm[f];
  Generalised u;
  if (!solve(mass_.matrix, next, u)) return;  // a mass matrix has no zero pivots; the old velocity would do
  // Energy beyond that of the centre of mass is set back to what it was: body axes must not pump.
  const double now = dot(u, next) - dot(next.linear, next.linear) / mass;
  const double scale = now > 0.0 && turning > 0.0 ? std::sqrt(turning / now) : 1.0;
  u.angular = scale * u.angular;
  for (double& rate : u.joint) rate *= scale;
  Vec3 joints{};
  for (int f = 0; f < kFlippers; ++f) {
    const double(&column)[6] = mass_.matrix.column[f];
    joints = joints + u.joint[f] * Vec3{column[0], column[1], column[2]};
  }
  u.linear = (1.0 / mass) * (next.linear - joints) - cross(u.angular, mass_.com_m);
  state_.velocity = u;
}

void TrackedPlant::report_energy() {
  const VehicleConfig& vehicle = config_.vehicle;
  report_.contacts = problem_.contacts.size();
  for (const ContactPoint& c : problem_.contacts) {
    if (c.grip != Grip::open) ++report_.loaded;
  }
  report_.kinetic_j = 0.5 * dot(state_.velocity, multiply(mass_.matrix, state_.velocity));
  report_.potential_j = mass_.mass_kg * config_.gravity_m_s2 * state_.com_world_m.z;
  for (int f = 0; f < kFlippers; ++f) {
    report_.potential_j += spring_energy(state_.flipper_set_rad[f] - state_.flipper_rad[f], vehicle);
  }
  ++counters_.steps;
  if (!report_.solver.converged) ++counters_.not_converged;
  counters_.penetration_m = std::max(counters_.penetration_m, report_.penetration_m);
}

}  // namespace sortie::hil
