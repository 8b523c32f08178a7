// SPDX-License-Identifier: BSD-3-Clause
// Which goal is next: of the mission, or, for a vehicle that seeks its place, of its looks.
#include <algorithm>
#include <cmath>

#include "planner/uav_pilot.hpp"
#include "rt/math.hpp"

namespace sortie::planner {
namespace {

using rt::Vector3;

template <std::size_t N>
Status take_goals(std::span<const UavGoal> goals, std::array<UavGoal, N>& to, std::uint32_t& count) {
  if (goals.size() > N) return Status::full;
  for (const UavGoal& goal : goals) {
    if (!rt::is_finite(goal.p_m) || !std::isfinite(goal.yaw_rad)) return Status::not_finite;
    if (rt::norm(goal.p_m) > kFarthestGoal_m || goal.wait_ns < 0) return Status::out_of_range;
  }
  std::copy(goals.begin(), goals.end(), to.begin());
  count = static_cast<std::uint32_t>(goals.size());
  return Status::ok;
}

}  // namespace

Status UavPilot::set_mission(std::span<const UavGoal> goals) { return take_goals(goals, mission_, goals_); }

Status UavPilot::set_looks(std::span<const UavGoal> looks) { return take_goals(looks, looks_, look_count_); }

Status UavPilot::place(const Vector3& p_own_map_m, const rt::Quaternion& q_own_map) {
  if (!rt::is_finite(p_own_map_m) || !rt::is_finite(q_own_map)) return Status::not_finite;
  p_own_map_m_ = p_own_map_m;
  q_own_map_ = q_own_map;
  placed_ = true;
  return Status::ok;
}

UavGoal UavPilot::on_own(const UavGoal& goal) const {
  if (!placed_) return goal;
  const Vector3 ahead = rt::rotate(q_own_map_, {1, 0, 0});
  return {rt::rotate(q_own_map_, goal.p_m) + p_own_map_m_, goal.yaw_rad + rt::atan2(ahead.y, ahead.x),
          goal.wait_ns};
}

// Round and round, until somebody says where it is; when it has looked for long enough it lands.
void UavPilot::choose_look(const rt::UavState& state) {
  if (step_ == PilotStep::waiting) {
    if (state.verdict != rt::UavVerdict::good) return;
    base_m_ = rt::to_vector(state.p_world_m);
  } else {  // over where it is: somebody may have flown it elsewhere
    const Vector3& here = control_.reference().p_m;
    base_m_ = {here.x, here.y, base_m_.z};
  }
  if (!placed_ && rounds_ >= config_.look_rounds) return control_.land();
  const UavGoal& look = looks_[next_look_];
  begin_goal({base_m_ + Vector3{0, 0, look.p_m.z}, look.yaw_rad, look.wait_ns});
  looking_ = true;
}

// The next goal of the mission, when nobody else is in control.
void UavPilot::choose_goal(const rt::UavState& state, rt::Nanoseconds now_ns) {
  if (held_ || has_goal_ || now_ns - start_ns_ < config_.start_wait_ns) return;
  if (step_ == PilotStep::landing || step_ == PilotStep::landed || step_ == PilotStep::stopped) return;
  if (look_count_ > 0 && !ready_) {
    choose_look(state);
  } else if (next_goal_ < goals_) {
    begin_goal(on_own(mission_[next_goal_]));
  } else if (config_.lands && step_ == PilotStep::arrived) {
    control_.land();
  }
}

}  // namespace sortie::planner
