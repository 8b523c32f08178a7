// SPDX-License-Identifier: BSD-3-Clause
// How the two axes share what the belts can do, and how their ramps are made equally long.
#include "planner/twist_limiter.hpp"

namespace sortie::planner {
namespace {

/// The ramp of an axis with `own` to go, when the axes go through the same share of their ways at all times:
/// the common profile is bounded by the axis that takes longer.
RampLimits in_step(double own, const RampLimits& limits, double other, const RampLimits& others) {
  // Nowhere to go; nothing to stretch. A way of 1e-320 would make a jerk of 0, and that a rate that is no
  // number.
  constexpr double kNowhere = 1e-100;
  if (!(std::fabs(own) > kNowhere)) return limits;
  const double ratio = std::fabs(own) / std::max(std::fabs(other), 1e-300);
  return {std::min(limits.acceleration, others.acceleration * ratio),
          std::min(limits.jerk, others.jerk * ratio)};
}

}  // namespace

SpeedTurn fit(const SpeedTurn& wish, const TwistLimits& limits) {
  const double belt = std::fabs(wish.speed_m_s) + limits.lever_m * std::fabs(wish.turn_rad_s);
  double share = 1.0;
  if (belt > limits.max_track_m_s) share = limits.max_track_m_s / belt;
  if (std::fabs(wish.speed_m_s) * share > limits.max_speed_m_s)
    share = limits.max_speed_m_s / std::fabs(wish.speed_m_s);
  if (std::fabs(wish.turn_rad_s) * share > limits.max_turn_rad_s)
    share = limits.max_turn_rad_s / std::fabs(wish.turn_rad_s);
  return {share * wish.speed_m_s, share * wish.turn_rad_s};
}

void TwistLimiter::step(const SpeedTurn& wish, const TwistLimits& limits, const TwistRamps& ramps,
                        double dt_s) {
  const SpeedTurn goal = fit(wish, limits);
  // What one axis has, or cannot help to get, the other may not have: the sum of both reaches never grows
  // beyond the belts' limit, by induction over the steps.
  const double turn_reach = limits.lever_m * turn_.reach(ramps.turn.jerk, dt_s);
  const double speed_room = std::max(0.0, limits.max_track_m_s - turn_reach);
  const double speed_goal = std::clamp(goal.speed_m_s, -speed_room, speed_room);
  const double speed_way = speed_goal - speed_.value;
  const double turn_way = goal.turn_rad_s - turn_.value;
  const RampLimits slow_speed = in_step(speed_way, ramps.speed, turn_way, ramps.turn);
  const RampLimits slow_turn = in_step(turn_way, ramps.turn, speed_way, ramps.speed);
  speed_.step(speed_goal, speed_.can_keep(speed_goal, slow_speed, dt_s) ? slow_speed : ramps.speed, dt_s);

  const double speed_reach = speed_.reach(ramps.speed.jerk, dt_s);
  const double turn_room = std::max(0.0, limits.max_track_m_s - speed_reach) / limits.lever_m;
  const double turn_goal = std::clamp(goal.turn_rad_s, -turn_room, turn_room);
  turn_.step(turn_goal, turn_.can_keep(turn_goal, slow_turn, dt_s) ? slow_turn : ramps.turn, dt_s);
}

}  // namespace sortie::planner
