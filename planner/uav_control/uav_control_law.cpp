// SPDX-License-Identifier: BSD-3-Clause
// Flies a multirotor to where it is told: the control law.
#include <algorithm>
#include <cmath>

#include "planner/uav_control/uav_control.hpp"

namespace sortie::planner {
namespace {

using rt::Vector3;

Vector3 no_longer_than(const Vector3& v, double most) {
  const double square = rt::dot(v, v);
  return square > most * most ? (most / std::sqrt(square)) * v : v;
}

constexpr double kLeastThrustShare = 0.2;  // of the weight: rotors that stand cannot hold an attitude

}  // namespace

// What the outer chains ask for.
struct UavControl::Wish {
  Vector3 force;       // specific force with feedback, m/s^2
  double feedforward;  // collective acceleration without it
  bool limited;        // what was asked for had to be cut
};

UavControl::Wish UavControl::wish(const rt::UavState& state) {
  const UavModel& model = config_.model;
  const TiltGains& tilt = gains_.tilt;
  const LiftGains& lift = gains_.lift;
  const Vector3 e_p =
      no_longer_than(rt::to_vector(state.p_world_m) - reference_.p_m, config_.max_position_error_m);
  const Vector3 e_v =
      no_longer_than(rt::to_vector(state.v_world_m_s) - reference_.v_m_s, config_.max_velocity_error_m_s);
  const Vector3 d = no_longer_than(rt::to_vector(state.d_world_m_s2), 0.8 * model.gravity_m_s2);
  const Vector3 base = reference_.a_m_s2 - d + Vector3{0, 0, model.gravity_m_s2};
  // The tilt that the horizontal chain asks for, as an acceleration.
  const double per_tilt = model.gravity_m_s2 / tilt.angle;
  Wish wish{base, rt::norm(base), false};
  wish.force.x -= per_tilt * (tilt.integral * integral_.x + tilt.position * e_p.x + tilt.velocity * e_v.x);
  wish.force.y -= per_tilt * (tilt.integral * integral_.y + tilt.position * e_p.y + tilt.velocity * e_v.y);
  wish.force.z -= lift.integral * integral_.z + lift.position * e_p.z + lift.velocity * e_v.z;

  // Height before sideways: the vertical part is kept within the rotors, then the tilt within its limit.
  const double rotors = static_cast<double>(model.rotors - allocation_.lost_count());
  const double most = 0.95 * rotors * model.max_thrust_n() / model.mass_kg;
  const double upright = std::clamp(wish.force.z, kLeastThrustShare * model.gravity_m_s2, most);
  wish.limited = upright != wish.force.z;
  wish.force.z = upright;
  const double across = std::sqrt(wish.force.x * wish.force.x + wish.force.y * wish.force.y);
  const double allowed =
      std::min(upright * tilt_slope_, std::sqrt(std::max(0.0, most * most - upright * upright)));
  if (across > allowed) {
    wish.force.x *= allowed / across;
    wish.force.y *= allowed / across;
    wish.limited = true;
    ++counters_.tilt_limited;
  }
  integrate(e_p, e_v, wish);
  return wish;
}

void UavControl::integrate(const Vector3& e_p, const Vector3& e_v, const Wish& wish) {
  if (phase_ == UavPhase::blind) return;
  // Exact for a motion of constant velocity. Conditional: while something is cut, only what shrinks the
  // integral passes.
  const double h = config_.period_s;
  const bool hold = wish.limited || thrust_limited_;
  const auto add = [h, hold](double& integral, double position, double velocity, double most) {
    const double step = h * (position + 0.5 * h * velocity);
    if (!hold || step * integral < 0.0) integral = std::clamp(integral + step, -most, most);
  };
  const double across = config_.max_integral_m_s2 * gains_.tilt.angle /
                        (config_.model.gravity_m_s2 * std::max(gains_.tilt.integral, 1e-9));
  const double up = config_.max_integral_m_s2 / std::max(gains_.lift.integral, 1e-9);
  add(integral_.x, e_p.x, e_v.x, across);
  add(integral_.y, e_p.y, e_v.y, across);
  add(integral_.z, e_p.z, e_v.z, up);
}

RotorWrench UavControl::control(const rt::UavState& state) {
  const UavModel& model = config_.model;
  const Vector3& inertia = model.inertia_kg_m2;
  const rt::Quaternion q = rt::to_quaternion(state.q_world_body);
  const Vector3 w = rt::to_vector(state.w_body_rad_s);
  const Wish wanted = wish(state);
  const rt::RotationMatrix r = rt::to_matrix(q);
  const Vector3 up{r.m[2], r.m[5], r.m[8]};
  const bool spins = allocation_.lost_count() > 0;
  rt::SinCos heading = rt::sincos(reference_.yaw_rad);
  if (spins) {  // the heading is given up: whatever it is, it is wanted
    const double size = std::sqrt(r.m[0] * r.m[0] + r.m[3] * r.m[3]);
    heading = size > 1e-6 ? rt::SinCos{r.m[3] / size, r.m[0] / size} : rt::SinCos{0.0, 1.0};
  }
  FlatBody body = flat_body(wanted.force, reference_, heading);
  if (spins) body.w_rad_s.z = w.z;

  // Attitude error in the body: from wanted to actual, twice the vector part of the quaternion.
  const rt::RotationMatrix wanted_r{
      {body.x.x, body.y.x, body.z.x, body.x.y, body.y.y, body.z.y, body.x.z, body.y.z, body.z.z}};
  const rt::Quaternion error = rt::conjugate(rt::from_matrix(wanted_r)) * q;
  const double side = error.w < 0.0 ? -2.0 : 2.0;
  const Vector3 e_r{side * error.x, side * error.y, side * error.z};
  // The wanted turn, seen in the actual body.
  const Vector3 e_w = w - rt::rotate_back(error, body.w_rad_s);

  // What the rotors make now.
  const RotorWrench& now = made_;
  const Vector3 spin{inertia.x * w.x, inertia.y * w.y, inertia.z * w.z};
  const Vector3 gyro = rt::cross(w, spin);
  const Vector3& load = watch_.load_rad_s2();
  const Vector3 alpha{(now.torque_n_m.x - gyro.x) / inertia.x + load.x,
                      (now.torque_n_m.y - gyro.y) / inertia.y + load.y,
                      (now.torque_n_m.z - gyro.z) / inertia.z + load.z};
  const TiltGains& tilt = gains_.tilt;
  const TurnGains& turn = gains_.turn;
  const Vector3& alpha_ref = body.alpha_rad_s2;
  const double per_thrust = 1.0 / body.thrust_m_s2;
  const Vector3& snap = lag_.lead_m_s4();
  const Vector3 lead{-per_thrust * rt::dot(body.y, snap), per_thrust * rt::dot(body.x, snap), 0.0};
  const Vector3 command{lead.x + alpha_ref.x - tilt.angle * e_r.x - tilt.rate * e_w.x -
                            tilt.acceleration * (alpha.x - alpha_ref.x) - load.x,
                        lead.y + alpha_ref.y - tilt.angle * e_r.y - tilt.rate * e_w.y -
                            tilt.acceleration * (alpha.y - alpha_ref.y) - load.y,
                        alpha_ref.z - turn.angle * e_r.z - turn.rate * e_w.z -
                            turn.acceleration * (alpha.z - alpha_ref.z) - load.z};

  const double feedforward = wanted.feedforward;
  const double lag = now.thrust_n / model.mass_kg - feedforward;
  const double thrust =
      rt::dot(wanted.force, up) + tau_s_ * body.thrust_rate_m_s3 - gains_.lift.acceleration * lag;
  RotorWrench wrench;
  wrench.thrust_n = model.mass_kg * std::max(thrust, kLeastThrustShare * model.gravity_m_s2);
  wrench.torque_n_m = {inertia.x * command.x + gyro.x, inertia.y * command.y + gyro.y,
                       spins ? 0.0 : inertia.z * command.z + gyro.z};
  return wrench;
}

}  // namespace sortie::planner
