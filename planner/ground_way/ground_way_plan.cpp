// SPDX-License-Identifier: BSD-3-Clause
// A plan of the planner of ways: from where to where, and what of it is handed out.
#include <algorithm>
#include <cmath>

#include "planner/ground_way/ground_way_planner.hpp"
#include "rt/math.hpp"

namespace sortie::planner {

namespace {

std::int32_t nearest_heading(double cos_yaw, double sin_yaw) {
  std::int32_t best = 0;
  double most = -2.0;
  for (std::int32_t h = 0; h < kHeadings; ++h) {
    const CellStep step = kHeadingSteps[static_cast<std::size_t>(h)];
    const double along =
        (cos_yaw * step.x + sin_yaw * step.y) * 65536.0 / static_cast<double>(step_length_q16(h));
    if (along > most) {
      most = along;
      best = h;
    }
  }
  return best;
}

}  // namespace

GroundPose GroundWayPlanner::on_map(const Step& step) const {
  GroundPose pose{static_cast<std::int32_t>(step.x - terrain_.low_x()),
                  static_cast<std::int32_t>(step.y - terrain_.low_y()), 0, step.heading};
  const GroundMap& map = terrain_.map();
  if (!map.is_inside(pose.x, pose.y) || map.cell(pose.x, pose.y).is_unknown()) return pose;
  const auto shift_mm = static_cast<std::int32_t>(1e3 * (level_m_ - terrain_.level_m()));
  const std::int32_t s = nearest_surface(map.cell(pose.x, pose.y), step.height_mm + shift_mm, 30'000);
  pose.surface = std::max(s, 0);
  return pose;
}

/// Where the next plan begins: a step of the way that is far enough ahead, or where the robot stands.
GroundPose GroundWayPlanner::find_start(const GroundStance& stance) {
  if (size_ > 0) {
    std::uint32_t i = std::min(driven(), size_ - 1);
    double way_m = 0.0;
    while (i + 1 < size_ && way_m < config_.ahead_m) {
      const double dx = terrain_.middle_m(steps_[i + 1].x) - terrain_.middle_m(steps_[i].x);
      const double dy = terrain_.middle_m(steps_[i + 1].y) - terrain_.middle_m(steps_[i].y);
      way_m += std::sqrt(dx * dx + dy * dy);
      ++i;
    }
    plan_from_ = first_ + i;
    return on_map(steps_[i]);
  }
  Step here;
  here.x = terrain_.cell_of(stance.p_m.x);
  here.y = terrain_.cell_of(stance.p_m.y);
  level_m_ = terrain_.level_m();
  here.height_mm = static_cast<std::int32_t>(1e3 * (stance.p_m.z - level_m_));
  here.heading = nearest_heading(stance.cos_yaw, stance.sin_yaw);
  plan_from_ = 0;
  return on_map(here);
}

/// The goal's cell; where it lies beyond the window, a place at its border, in the goal's direction or, when
/// such a place could not be reached, beside it.
GroundPose GroundWayPlanner::find_goal(const GroundStance& stance) {
  const std::int32_t border = path_.footprints().reach() + 1;
  double x_m = progress_.goal_m[0];
  double y_m = progress_.goal_m[1];
  const auto fits = [&](double at_x_m, double at_y_m) {
    const std::int64_t x = terrain_.cell_of(at_x_m) - terrain_.low_x();
    const std::int64_t y = terrain_.cell_of(at_y_m) - terrain_.low_y();
    return x >= border && y >= border && x < config_.lattice.nx - border && y < config_.lattice.ny - border;
  };
  is_intermediate_ = !fits(x_m, y_m);
  if (is_intermediate_) {
    const double side = attempt_ % 2 == 0 ? 1.0 : -1.0;
    const rt::SinCos turn = rt::sincos(side * 0.2 * static_cast<double>((attempt_ + 1) / 2));
    const double dx = x_m - stance.p_m.x;
    const double dy = y_m - stance.p_m.y;
    const double length = std::sqrt(dx * dx + dy * dy);
    const double share = length > 0.0 ? 1.0 / length : 0.0;
    const double ux = share * (turn.cos * dx - turn.sin * dy);
    const double uy = share * (turn.sin * dx + turn.cos * dy);
    // The last cell on that line that fits; the robot's own always does.
    double low = 0.0;
    double high = length;
    for (int i = 0; i < 24; ++i) {
      const double middle = 0.5 * (low + high);
      (fits(stance.p_m.x + middle * ux, stance.p_m.y + middle * uy) ? low : high) = middle;
    }
    x_m = stance.p_m.x + low * ux;
    y_m = stance.p_m.y + low * uy;
  }
  GroundPose goal{static_cast<std::int32_t>(terrain_.cell_of(x_m) - terrain_.low_x()),
                  static_cast<std::int32_t>(terrain_.cell_of(y_m) - terrain_.low_y()), 0, kAnyHeading};
  const GroundCell& cell = terrain_.map().cell(goal.x, goal.y);
  if (cell.state[0] != GroundState::carries && cell.state[1] != GroundState::unknown) goal.surface = 1;
  return goal;
}

void GroundWayPlanner::begin_plan(const GroundStance& stance) {
  terrain_.hand_over();
  ++output_.plans;
  plan_start_ = find_start(stance);
  plan_goal_ = find_goal(stance);
  start_plan();
}

// What a plan comes to after so many units hangs on its map alone, not on plans before: so it can be made
// again from a keyframe.
void GroundWayPlanner::start_plan() {
  path_.forget_prices();
  terrain_.forget_changes();
  path_.begin(terrain_.map(), plan_start_, plan_goal_);
  plan_slices_ = 0;
  is_planning_ = true;
}

void GroundWayPlanner::step() {
  ++plan_slices_;
  const GroundPathState state = path_.run(terrain_.map(), kSlice);
  output_.plan = static_cast<std::uint32_t>(state);
  if (state == GroundPathState::running) return;
  if (state == GroundPathState::found && path_.work().units < config_.settle) return;
  is_planning_ = false;
  if (path_.has_way()) {
    adopt();
  } else {
    refused(state);
  }
}

/// No way there: another place on the way to it, or none at all.
void GroundWayPlanner::refused(GroundPathState state) {
  constexpr std::uint32_t kAttempts = 16;
  output_.unseen = 0;
  cells_wait_ = 0;
  if (state == GroundPathState::outdated) return;
  const bool is_start = state == GroundPathState::start_unknown || state == GroundPathState::start_blocked ||
                        state == GroundPathState::start_outside;
  // At the end of its way, beside the last place of it: from where it stands there may be one.
  if (is_start && standing_ && size_ > 0 && driven() >= size_) drop_way();
  if (is_intermediate_ && !is_start && attempt_ + 1 < kAttempts) {
    ++attempt_;
    return;
  }
  attempt_ = 0;
  state_ = GroundWayState::none;
}

void GroundWayPlanner::adopt() {
  const std::span<const GroundStep> way = path_.drivable();
  cells_wait_ = static_cast<std::uint32_t>(path_.unseen(terrain_.map(), unseen_));
  unseen_low_[0] = terrain_.low_x();
  unseen_low_[1] = terrain_.low_y();
  output_.unseen = cells_wait_;
  state_ = GroundWayState::looking;
  if (way.empty()) return;
  // The robot is beyond the place where this way begins: it comes too late.
  const std::uint32_t now = first_ + driven();
  if (size_ > 0 && (plan_from_ < first_ || plan_from_ >= first_ + size_ ||
                    (now + 1 >= plan_from_ && plan_from_ + 1 < first_ + size_)))
    return;
  const std::uint32_t old = size_;
  if (size_ > 0) {
    // Steps that lie behind make room.
    const std::uint32_t behind = now > first_ + 1 ? now - 1 - first_ : 0;
    std::copy(steps_ + behind, steps_ + size_, steps_);
    size_ -= behind;
    first_ += behind;
    size_ = plan_from_ - first_ + 1;
  } else {
    level_m_ = terrain_.level_m();
    ++output_.series;
    first_ = 0;
    const GroundPose& pose = way[0].pose;
    steps_[0] = {terrain_.low_x() + pose.x,
                 terrain_.low_y() + pose.y,
                 terrain_.map().cell(pose.x, pose.y).height_mm[pose.surface],
                 pose.heading,
                 0,
                 0};
    size_ = 1;
  }
  adopted_ = true;
  bool fits = true;
  for (std::size_t i = 1; i < way.size() && fits; ++i) fits = append(way[i], way[i - 1]);
  output_.whole = fits && !is_intermediate_ && way.size() == path_.way().size() && path_.is_whole() ? 1u : 0u;
  if (old > 1) ++output_.replanned;
  if (size_ > 1) waits_since_ns_ = -1;
}

bool GroundWayPlanner::append(const GroundStep& step, const GroundStep& before) {
  constexpr std::uint8_t kMostTimes = 4;
  const Motion& motion = path_.motions().motion(before.pose.heading, step.motion);
  const auto shift_mm = static_cast<std::int32_t>(1e3 * (terrain_.level_m() - level_m_));
  const Step next{terrain_.low_x() + step.pose.x,
                  terrain_.low_y() + step.pose.y,
                  terrain_.map().cell(step.pose.x, step.pose.y).height_mm[step.pose.surface] + shift_mm,
                  step.pose.heading,
                  step.motion,
                  1};
  Step& last = steps_[size_ - 1];
  const bool is_straight = motion.heading == before.pose.heading;
  const bool may_grow = first_ + size_ - 1 > plan_from_;
  if (is_straight && may_grow && last.times > 0 && last.times < kMostTimes && last.motion == step.motion &&
      last.heading == step.pose.heading && size_ > 1 && steps_[size_ - 2].heading == last.heading) {
    const std::uint8_t times = last.times;
    last = next;
    last.times = static_cast<std::uint8_t>(times + 1);
    return true;
  }
  if (size_ == GroundWay::kMostSteps) return false;
  steps_[size_++] = next;
  return true;
}

}  // namespace sortie::planner
