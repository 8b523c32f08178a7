// SPDX-License-Identifier: BSD-3-Clause
// Motion of the tracked robot. Attitude is Rz(yaw) * Ry(pitch) * Rx(roll); tracks turn about the body's up.
#include "hil/kinematic_robot.hpp"

#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

void check(const RobotConfig& c) {
  require("robot", c.track_distance_m > 0.0 && c.contact_length_m > 0.0,
          "track_distance_m and contact_length_m must be above 0");
  require("robot", c.outline_length_m > 0.0 && c.outline_width_m > 0.0 && c.outline_height_m > c.clearance_m,
          "the outline must have a size, and outline_height_m must be above clearance_m");
  require("robot", c.steering_efficiency > 0.0 && c.steering_efficiency <= 1.0,
          "steering_efficiency must be above 0 and at most 1");
  require("robot", c.slip_left < 1.0 && c.slip_right < 1.0, "slip_left and slip_right must be below 1");
  require("robot", c.suspension_hz > 0.0 && c.suspension_hz <= 100.0,
          "suspension_hz must be above 0 and at most 100");
  require("robot",
          std::isfinite(c.start_x_m) && std::isfinite(c.start_y_m) && std::isfinite(c.start_yaw_rad) &&
              std::isfinite(c.turning_centre_x_m),
          "start pose and turning_centre_x_m must be finite");
}

double wrap(double angle_rad) {
  constexpr double kTurn = 6.283185307179586;
  return angle_rad - kTurn * std::floor(angle_rad / kTurn + 0.5);
}

/// sin(a) / a, the ratio of a chord to its arc at half the turned angle.
double sinc(double a) { return std::fabs(a) < 1e-4 ? 1.0 - a * a / 6.0 : rt::sin(a) / a; }

}  // namespace

KinematicRobot::KinematicRobot(const RobotConfig& config, const World& world, rt::Nanoseconds start_ns,
                               rt::Nanoseconds step_ns)
    : config_((check(config), config)),
      world_(&world),
      step_ns_(step_ns),
      drives_(config.drives, step_ns, "robot"),
      height_(config.suspension_hz, rt::to_seconds(step_ns)),
      pitch_(height_),
      roll_(height_),
      yaw_rad_(wrap(config.start_yaw_rad)) {
  const Ground ground = ground_at(config.start_x_m, config.start_y_m, yaw_rad_);
  require("robot", !obstructed(config.start_x_m, config.start_y_m, yaw_rad_, ground.height_m),
          "the robot starts inside of something; change start_x_m, start_y_m or the hall");
  height_.reset(ground.height_m);
  pitch_.reset(ground.pitch_rad);
  roll_.reset(ground.roll_rad);
  roughness_m_ = ground.roughness_m;
  ground_m_ = ground.height_m;
  motion_.stamp_ns = start_ns;
  motion_.p_world_body_m = {config.start_x_m, config.start_y_m, ground.height_m};
  update_motion(0.0, 0.0);
}

void KinematicRobot::step() {
  motion_.stamp_ns += step_ns_;
  const TrackDrive& left = drives_.left();
  const TrackDrive& right = drives_.right();
  const double left_before = left.travel_m();
  const double right_before = right.travel_m();
  constexpr double kGravity_m_s2 = 9.81;
  drives_.advance(motion_.stamp_ns, kGravity_m_s2 * rt::sin(pitch_.value()));
  const double grip_left = 1.0 - config_.slip_left;
  const double grip_right = 1.0 - config_.slip_right;
  move(grip_left * (left.travel_m() - left_before), grip_right * (right.travel_m() - right_before));
  if (held_) {
    ++obstructed_steps_;
    update_motion(0.0, 0.0);
  } else {
    update_motion(grip_left * left.speed_m_s(), grip_right * right.speed_m_s());
  }
}

void KinematicRobot::move(double left_m, double right_m) {
  // Turn about the body's up axis, and what it means about the world's; attitude in the middle of the step.
  const double half_s = 0.5 * rt::to_seconds(step_ns_);
  const double pitch = pitch_.value() + pitch_.rate() * half_s;
  const double roll = roll_.value() + roll_.rate() * half_s;
  const auto [sin_pitch, cos_pitch] = rt::sincos(pitch);
  const auto [sin_roll, cos_roll] = rt::sincos(roll);
  const double turn = config_.steering_efficiency * (right_m - left_m) / config_.track_distance_m;
  const double dyaw = (turn + 2.0 * half_s * pitch_.rate() * sin_roll) / (cos_roll * cos_pitch);
  // On flat ground this is the exact arc: the chord of a constant twist, at half the turned angle.
  const double forward = 0.5 * (left_m + right_m);
  const double sideways = -turn * config_.turning_centre_x_m;
  const double along = forward * cos_pitch + sideways * sin_pitch * sin_roll;
  const double across = sideways * cos_roll;
  const double chord = sinc(0.5 * dyaw);
  const double heading = yaw_rad_ + 0.5 * dyaw;
  const auto [s, c] = rt::sincos(heading);
  const double x = motion_.p_world_body_m.x + chord * (c * along - s * across);
  const double y = motion_.p_world_body_m.y + chord * (s * along + c * across);
  const double yaw = wrap(yaw_rad_ + dyaw);

  Ground ground = ground_at(x, y, yaw);
  const bool too_rough = ground.roughness_m > config_.max_step_m && ground.roughness_m > roughness_m_;
  // A whole track would leave an edge at once: the plane through the ground fits, but the robot would fall.
  const bool falls = std::fabs(ground.height_m - ground_m_) > config_.max_step_m;
  held_ = too_rough || falls || obstructed(x, y, yaw, ground.height_m);
  if (held_) {
    ground = ground_at(motion_.p_world_body_m.x, motion_.p_world_body_m.y, yaw_rad_);
  } else {
    motion_.p_world_body_m.x = x;
    motion_.p_world_body_m.y = y;
    yaw_rad_ = yaw;
  }
  roughness_m_ = ground.roughness_m;
  ground_m_ = ground.height_m;
  height_.advance(ground.height_m);
  pitch_.advance(ground.pitch_rad);
  roll_.advance(ground.roll_rad);
}

void KinematicRobot::update_motion(double left_m_s, double right_m_s) {
  const double pitch = pitch_.value();
  const double roll = roll_.value();
  const auto [sin_pitch, cos_pitch] = rt::sincos(pitch);
  const auto [sin_roll, cos_roll] = rt::sincos(roll);
  const double turn_rate = config_.steering_efficiency * (right_m_s - left_m_s) / config_.track_distance_m;
  // A body that is held does not turn about the world's up axis, whatever its attitude does.
  const double yaw_rate = held_ ? 0.0 : (turn_rate + pitch_.rate() * sin_roll) / (cos_roll * cos_pitch);
  const double sideways = -turn_rate * config_.turning_centre_x_m;
  const double along = 0.5 * (left_m_s + right_m_s) * cos_pitch + sideways * sin_pitch * sin_roll;
  const double across = sideways * cos_roll;
  const auto [s, c] = rt::sincos(yaw_rad_);
  motion_.p_world_body_m.z = height_.value();
  motion_.v_world_m_s = {c * along - s * across, s * along + c * across, height_.rate()};
  motion_.q_world_body = from_yaw_pitch_roll(yaw_rad_, pitch, roll);
  motion_.w_body_rad_s = {roll_.rate() - yaw_rate * sin_pitch,
                          pitch_.rate() * cos_roll + yaw_rate * cos_pitch * sin_roll,
                          yaw_rate * cos_pitch * cos_roll - pitch_.rate() * sin_roll};
  motion_.left_m = drives_.left().travel_m();
  motion_.right_m = drives_.right().travel_m();
}

}  // namespace sortie::hil
