// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/plant/drive_plan.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::bench {

namespace {

double ramp_integral(double t_s, double rise_s) {
  if (t_s <= 0) return 0;
  return t_s < rise_s ? 0.5 * t_s * t_s / rise_s : t_s - 0.5 * rise_s;
}

BeltSpeeds full_speed(const Pulse& pulse) {
  const double turn = pulse.turn_rad_s * DrivePlan::kHalfSpan_m;
  return {pulse.forward_m_s - turn, pulse.forward_m_s + turn};
}

}  // namespace

DrivePlan::DrivePlan(const BenchScene& scene)
    : pulses_(scene.pulses), acceleration_m_s2_(0.25 * scene.friction * 9.81) {}

double DrivePlan::held_s(const Pulse& pulse, double t_s) const {
  const BeltSpeeds full = full_speed(pulse);
  const double rise_s = std::max(std::fabs(full.left_m_s), std::fabs(full.right_m_s)) / acceleration_m_s2_;
  return ramp_integral(t_s - pulse.begin_s, rise_s) - ramp_integral(t_s - pulse.end_s, rise_s);
}

BeltSpeeds DrivePlan::belts(double t_s, double dt_s) const {
  BeltSpeeds sum;
  for (const Pulse& pulse : pulses_) {
    const BeltSpeeds full = full_speed(pulse);
    const double share = (held_s(pulse, t_s + dt_s) - held_s(pulse, t_s)) / dt_s;
    sum.left_m_s += share * full.left_m_s;
    sum.right_m_s += share * full.right_m_s;
  }
  return sum;
}

BenchPose DrivePlan::closed_form(const BenchPose& start, double t_s) const {
  BenchPose pose = start;
  for (const Pulse& pulse : pulses_) {
    const double held = held_s(pulse, t_s);
    const double turned = pulse.turn_rad_s * held;
    const double radius = pulse.turn_rad_s != 0 ? pulse.forward_m_s / pulse.turn_rad_s : 0;
    const hil::Vec3 moved = pulse.turn_rad_s != 0
                                ? hil::Vec3{radius * std::sin(turned), radius * (1 - std::cos(turned)), 0}
                                : hil::Vec3{pulse.forward_m_s * held, 0, 0};
    pose.p_world_m = pose.p_world_m + hil::rotate(pose.q_world_body, moved);
    pose.q_world_body = pose.q_world_body * hil::from_yaw_pitch_roll(turned, 0, 0);
  }
  return pose;
}

}  // namespace sortie::bench
