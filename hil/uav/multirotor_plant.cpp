// SPDX-License-Identifier: BSD-3-Clause
// A simulated multirotor in flight.
#include "hil/uav/multirotor_plant.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::hil {

MultirotorPlant::MultirotorPlant(const MultirotorConfig& config, const Vec3& p_world_m, double yaw_rad)
    : dynamics_(config), charge_(config.battery.start_charge) {
  state_.p_world_m = p_world_m;
  state_.q_world_body = from_yaw_pitch_roll(yaw_rad, 0.0, 0.0);
  on_ground_ = config.ground && p_world_m.z <= 0.0;
  const double share = on_ground_ ? 0.0 : 1.0;
  const double thrust = dynamics_.mass_kg() * config.gravity_m_s2 / static_cast<double>(config.rotors);
  for (std::uint32_t i = 0; i < config.rotors; ++i) {
    speeds_[i] = references_[i] = share * std::sqrt(thrust / config.thrust_n_s2);
  }
}

Status MultirotorPlant::add_gust(const Gust& gust) {
  if (gust_count_ == kMaxGusts) return Status::full;
  gusts_[gust_count_++] = gust;
  return Status::ok;
}

void MultirotorPlant::set_thrust_share(double share) {
  for (std::uint32_t i = 0; i < dynamics_.config().rotors; ++i) {
    if (dynamics_.rotor_share(i) > 0.0) dynamics_.set_rotor_share(i, share);
  }
}

void MultirotorPlant::command(const double* speeds_rad_s) {
  const MultirotorConfig& config = dynamics_.config();
  const double ceiling = config.max_speed_rad_s * voltage_share_;
  const double follow = config.battery.speed_loop ? 1.0 : voltage_share_;
  for (std::uint32_t i = 0; i < config.rotors; ++i) {
    const double wish = speeds_rad_s[i] * follow;
    const double held = wish > 0.0 ? std::min(wish, ceiling) : 0.0;  // also for a NaN
    if (!(held == wish)) ++commands_changed_;
    references_[i] = held;
  }
}

MultirotorWeather MultirotorPlant::weather() const {
  MultirotorWeather weather{wind_, {}, {}};
  for (std::uint32_t i = 0; i < gust_count_; ++i) {
    const double since = time_s_ - gusts_[i].start_s;
    // Half a microsecond of slack: the sum of many steps may miss the edge by rounding.
    if (since >= -5e-7 && since < gusts_[i].length_s - 5e-7)
      weather.force_n = weather.force_n + gusts_[i].force_n;
  }
  return weather;
}

Status MultirotorPlant::step(double dt_s) {
  if (!std::isfinite(dt_s)) return Status::not_finite;
  if (dt_s < 1e-4 * (1 - 1e-9) || dt_s > 0.05 * (1 + 1e-9)) return Status::out_of_range;
  const MultirotorState before = state_;
  if (mode_ == MultirotorMode::exact) {
    dynamics_.step_exact(state_, speeds_, references_, weather(), dt_s);
  } else {
    dynamics_.step_parity(state_, speeds_, references_, weather(), dt_s);
  }
  if (dynamics_.config().ground) meet_ground();
  time_s_ += dt_s;
  integrate_inertial(before, dt_s);
  drain(dt_s);
  return Status::ok;
}

void MultirotorPlant::meet_ground() {
  if (state_.p_world_m.z > 0.0) {
    on_ground_ = false;
    return;
  }
  if (!on_ground_ && !touch_down_.happened) {
    touch_down_ = {true,      time_s_, state_.p_world_m, norm(state_.v_world_m_s), -state_.v_world_m_s.z,
                   tilt_rad()};
  }
  on_ground_ = true;
  // Legs that neither slide nor bounce; the body stands level until thrust lifts it.
  state_.p_world_m.z = 0.0;
  state_.v_world_m_s = {0, 0, std::max(0.0, state_.v_world_m_s.z)};
  state_.w_body_rad_s = {};
  const Quat& q = state_.q_world_body;
  state_.q_world_body = normalized({q.w, 0, 0, q.z});
}

void MultirotorPlant::integrate_inertial(const MultirotorState& before, double dt_s) {
  const auto swing = [this](const MultirotorState& s) {  // of the sensor about the origin, world frame
    return rotate(s.q_world_body, cross(s.w_body_rad_s, imu_arm_m_));
  };
  const Vec3 dv = state_.v_world_m_s - before.v_world_m_s +
                  Vec3{0, 0, dynamics_.config().gravity_m_s2 * dt_s} + (swing(state_) - swing(before));
  inertial_.add(before.q_world_body, state_.q_world_body, dv, dt_s);
}

double MultirotorPlant::tilt_rad() const {
  const Quat& q = state_.q_world_body;
  const double across = 2.0 * std::sqrt((q.w * q.w + q.z * q.z) * (q.x * q.x + q.y * q.y));
  return rt::atan2(across, 1.0 - 2.0 * (q.x * q.x + q.y * q.y));
}

void MultirotorPlant::drain(double dt_s) {
  const MultirotorConfig& config = dynamics_.config();
  const BatteryConfig& battery = config.battery;
  if (!(battery.capacity_as > 0.0)) return;
  double shaft_w = 0.0;
  for (std::uint32_t i = 0; i < config.rotors; ++i) {
    const double speed = speeds_[i];
    shaft_w += dynamics_.rotor_share(i) * config.moment_m * config.thrust_n_s2 * speed * speed * speed;
  }
  const double open_v = battery.empty_v + charge_ * (battery.full_v - battery.empty_v);
  // P = V I and V = U - R I: the smaller root. Beyond the largest power that the battery can give, V = U / 2.
  const double power_w = shaft_w / battery.efficiency;
  const double square = open_v * open_v - 4.0 * battery.resistance_ohm * power_w;
  const double terminal_v = 0.5 * (open_v + std::sqrt(std::max(0.0, square)));
  charge_ = std::max(0.0, charge_ - power_w / terminal_v * dt_s / battery.capacity_as);
  voltage_share_ = terminal_v / battery.full_v;
}

}  // namespace sortie::hil
