// SPDX-License-Identifier: BSD-3-Clause
// One step of the tracked vehicle.
#include "hil/plant/tracked_plant.hpp"

#include <algorithm>
#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

constexpr double kFastestBelt_m_s = 50.0;
constexpr double kWidestMargin_m = 0.25;

bool in_range(double value, double low, double high) { return value >= low && value <= high; }

void check(const PlantConfig& c) {
  const bool good = in_range(c.gravity_m_s2, 0.0, 100.0) && in_range(c.compliance_s, 1e-9, 1e-3) &&
                    in_range(c.tolerance_share, 1e-12, 1e-2) && c.newton_iterations > 0 &&
                    in_range(c.slop_m, 0.0, 0.01) && in_range(c.correction_rate, 0.0, 1.0) &&
                    in_range(c.correction_speed_m_s, 0.0, 10.0) && in_range(c.margin_m, 0.0, 0.1);
  require("plant", good, "a setting of gravity, solver or correction is out of range");
}

}  // namespace

TrackedPlant::TrackedPlant(const PlantConfig& config, const PlantScene& scene, ContactSolver solver)
    : config_(config), solver_(solver), model_(config.vehicle), finder_(model_, scene) {
  check(config);
  for (int f = 0; f < kFlippers; ++f) {
    require("plant", std::isfinite(config.start_flipper_rad[f]), "start_flipper_rad");
    state_.flipper_rad[f] = config.start_flipper_rad[f];
    state_.flipper_set_rad[f] = config.start_flipper_rad[f];
  }
  place(config.start_m, config.start_q_world_body);
}

void TrackedPlant::place(const Vec3& p_world_body_m, const Quat& q_world_body, const Generalised& velocity) {
  state_.q_world_body = normalized(q_world_body);
  state_.velocity = velocity;
  R_world_body_ = to_matrix(state_.q_world_body);
  model_.mass_at(state_.flipper_rad, mass_);
  p_world_body_m_ = p_world_body_m;
  state_.com_world_m = p_world_body_m + R_world_body_ * mass_.com_m;
  old_velocity_ = velocity;
  old_R_world_body_ = R_world_body_;
  problem_.contacts.clear();
  finder_.remember(problem_);
}

Status TrackedPlant::step(const PlantCommand& command, double dt_s) {
  bool finite = std::isfinite(command.left_m_s) && std::isfinite(command.right_m_s) && std::isfinite(dt_s);
  for (const double angle : command.flipper_rad) finite = finite && std::isfinite(angle);
  if (!finite) return Status::not_finite;
  if (!in_range(dt_s, kShortestStep_s, kLongestStep_s) || std::fabs(command.left_m_s) > kFastestBelt_m_s ||
      std::fabs(command.right_m_s) > kFastestBelt_m_s) {
    return Status::out_of_range;
  }
  dt_s_ = dt_s;
  report_ = {};
  old_velocity_ = state_.velocity;
  old_R_world_body_ = R_world_body_;
  pose_problem(command, dt_s);

  SolverOptions options;
  options.newton_iterations = config_.newton_iterations;
  // Velocities of 1 m/s carry rounding of 1e-16 m/s, which the compliance turns into momentum.
  const double rounding =
      1e-14 * (norm(state_.velocity.linear) + norm(state_.velocity.angular)) / problem_.compliance;
  options.tolerance_ns =
      config_.tolerance_share * model_.mass_kg() * std::max(1.0, config_.gravity_m_s2) * dt_s + rounding;
  Generalised velocity = state_.velocity;
  report_.solver = solver_(problem_, velocity, options);
  finder_.remember(problem_);
  state_.velocity = velocity;
  const Generalised correction = correct(dt_s);
  integrate(correction, command, dt_s);
  report_energy();
  return Status::ok;
}

void TrackedPlant::pose_problem(const PlantCommand& command, double dt_s) {
  const VehicleConfig& vehicle = config_.vehicle;
  problem_.mass = mass_.matrix;
  problem_.compliance = config_.compliance_s / (model_.mass_kg() * dt_s);
  problem_.gyration_m = model_.gyration_m();
  const Vec3 gravity = back(R_world_body_, Vec3{0.0, 0.0, -config_.gravity_m_s2});
  Generalised& momentum = problem_.momentum;
  momentum = multiply(mass_.matrix, state_.velocity);
  momentum.linear = momentum.linear + (dt_s * mass_.mass_kg) * gravity;
  momentum.angular = momentum.angular + (dt_s * mass_.mass_kg) * cross(mass_.com_m, gravity);
  const double joint_speed = vehicle.servo_damping_nms_rad + dt_s * vehicle.servo_stiffness_nm_rad;
  for (int f = 0; f < kFlippers; ++f) {
    const double(&column)[6] = mass_.matrix.column[f];  // its linear part is mass x lever of the flipper
    momentum.joint[f] += dt_s * dot(Vec3{column[0], column[1], column[2]}, gravity);
    const double room = vehicle.servo_rate_rad_s * dt_s;
    state_.flipper_set_rad[f] += std::clamp(command.flipper_rad[f] - state_.flipper_set_rad[f], -room, room);
    JointDrive& drive = problem_.drives[f];
    drive.compliance = 1.0 / (dt_s * joint_speed);
    drive.bias_rad_s =
        -vehicle.servo_stiffness_nm_rad * (state_.flipper_set_rad[f] - state_.flipper_rad[f]) / joint_speed;
    drive.limit_nms = vehicle.servo_torque_nm * dt_s;
  }
  double speed = norm(state_.velocity.linear) + norm(state_.velocity.angular) + config_.gravity_m_s2 * dt_s;
  for (const double rate : state_.velocity.joint) speed = std::max(speed, speed + 0.4 * std::fabs(rate));
  const double margin = std::min(kWidestMargin_m, config_.margin_m + 1.5 * speed * dt_s);
  const BeltMotion belts = belt_motion(command.left_m_s, command.right_m_s, dt_s, vehicle);
  finder_.find({p_world_body_m_, R_world_body_}, mass_, belts, margin, dt_s, problem_);
}

Motion TrackedPlant::motion(rt::Nanoseconds stamp_ns) const {
  Motion motion;
  motion.stamp_ns = stamp_ns;
  motion.p_world_body_m = p_world_body_m_;
  motion.q_world_body = state_.q_world_body;
  motion.v_world_m_s = R_world_body_ * state_.velocity.linear;
  motion.w_body_rad_s = state_.velocity.angular;
  motion.left_m = state_.left_m;
  motion.right_m = state_.right_m;
  return motion;
}

Vec3 TrackedPlant::velocity_world_m_s(const Vec3& lever_m) const {
  return R_world_body_ * (state_.velocity.linear + cross(state_.velocity.angular, lever_m));
}

Vec3 TrackedPlant::specific_force_m_s2(const Vec3& lever_m) const {
  if (counters_.steps == 0) return {};
  const Vec3 before = old_R_world_body_ * (old_velocity_.linear + cross(old_velocity_.angular, lever_m));
  const Vec3 change = (1.0 / dt_s_) * (velocity_world_m_s(lever_m) - before);
  return back(R_world_body_, change + Vec3{0.0, 0.0, config_.gravity_m_s2});
}

}  // namespace sortie::hil
