// SPDX-License-Identifier: BSD-3-Clause
#include "planner/mission.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::planner {

Status Mission::set_steps(std::span<const MissionStep> steps) {
  if (steps.size() > kMaxSteps) return Status::full;
  rt::Nanoseconds before_ns = -1;
  for (const MissionStep& step : steps) {
    if (!std::isfinite(step.speed_m_s) || !std::isfinite(step.turn_rad_s)) return Status::not_finite;
    if (step.at_ns < 0) return Status::out_of_range;
    if (step.at_ns <= before_ns) return Status::time_backwards;
    before_ns = step.at_ns;
  }
  if (!steps.empty() && (steps.back().speed_m_s != 0.0 || steps.back().turn_rad_s != 0.0))
    return Status::out_of_range;
  std::copy(steps.begin(), steps.end(), steps_.begin());
  size_ = static_cast<std::uint32_t>(steps.size());
  next_ = 0;
  posture_ = -1;
  return Status::ok;
}

const MissionStep* Mission::at(rt::Nanoseconds since_start_ns) {
  for (; next_ < size_ && steps_[next_].at_ns <= since_start_ns; ++next_) {  // at most 64 in a life
    if (steps_[next_].posture >= 0) posture_ = steps_[next_].posture;
  }
  return next_ == 0 ? nullptr : &steps_[next_ - 1];
}

}  // namespace sortie::planner
