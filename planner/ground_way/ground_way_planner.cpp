// SPDX-License-Identifier: BSD-3-Clause
// A job of the planner of ways: what is known of the robot, what was handed out, and when to plan.
#include "planner/ground_way/ground_way_planner.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner {

namespace {

constexpr double kFarthest_m = 1e5;

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

GroundWayPlanner::GroundWayPlanner(const GroundWayConfig& config, std::int32_t elevation_cell_mm,
                                   rt::Arena& arena)
    : config_(config),
      terrain_(config.lattice, config.rules, elevation_cell_mm, arena),
      memory_(GroundPathMemory::take(arena, config.lattice, config.columns, config.open, 1024)),
      path_(config.lattice, terrain_.prices(), memory_),
      usable_(terrain_.usable() && arena.refused() == 0) {}

Status GroundWayPlanner::begin(const mapping::ElevationView& view, const rt::PoseEstimate& pose,
                               bool standing, const GroundWayProgress& progress, rt::Nanoseconds now_ns) {
  progress_ = progress;
  standing_ = standing;
  now_ns_ = now_ns;
  const rt::Vector3 p_m = rt::to_vector(pose.p_world_body_m);
  const rt::Quaternion q = rt::to_quaternion(pose.q_world_body);
  const auto is_place = [](double m) { return std::fabs(m) <= kFarthest_m; };
  const bool is_told = progress.goal != 0;
  Status status = Status::ok;
  if (!is_place(p_m.x) || !is_place(p_m.y) || !is_place(p_m.z) || !rt::is_finite(q) ||
      (is_told && !(is_place(progress.goal_m[0]) && is_place(progress.goal_m[1])))) {
    status = Status::not_finite;
  } else if (pose.flags == 0 || static_cast<double>(now_ns - pose.stamp_ns) > 1e9 * config_.most_pose_age_s) {
    status = Status::stale;
  }
  if (progress.goal != goal_) {
    goal_ = progress.goal;
    drop_way();
    attempt_ = 0;
    cells_wait_ = 0;
    waits_since_ns_ = -1;
    trusts_ = true;
    terrain_.forgive();
  }
  if (status != Status::ok || !usable_ || !is_told) {
    drop_way();
    state_ = is_told ? GroundWayState::waiting : GroundWayState::idle;
    return status;
  }
  const rt::SinCos yaw = rt::sincos(rt::yaw_of(q));
  const GroundStance stance{p_m, yaw.cos, yaw.sin};
  if (trusts_) terrain_.trust(p_m);
  trusts_ = false;
  const bool leapt = terrain_.follow(p_m);
  if (leapt) is_planning_ = false;
  terrain_.read(view, stance, leapt);
  if (progress.arrived) {
    is_planning_ = false;
    state_ = GroundWayState::arrived;
    return status;
  }
  if (progress.lost && size_ > 0 && progress.series == output_.series) {
    ++output_.lost;
    drop_way();
  }
  if (state_ != GroundWayState::none) state_ = GroundWayState::looking;
  verify(p_m);
  wait_for_sight();
  if (!is_planning_ && (size_ > 0 ? output_.whole == 0 : standing)) begin_plan(stance);
  return status;
}

void GroundWayPlanner::drop_way() {
  size_ = 0;
  first_ = 0;
  is_planning_ = false;
  output_.whole = 0;
  state_ = GroundWayState::looking;
}

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

/// True where all cells that a slot needs carry, by the newest heights.
bool GroundWayPlanner::stands(std::int64_t x, std::int64_t y, std::int32_t height_mm,
                              std::int32_t slot) const {
  const FootprintTable& footprints = path_.footprints();
  const std::int32_t reach = footprints.reach(slot);
  for (std::int32_t dy = -reach; dy <= reach; ++dy) {
    const FootprintRow& row = footprints.row(slot, dy);
    for (std::int32_t dx = row.low; dx <= row.high; ++dx) {
      if (!terrain_.is_inside(x + dx, y + dy)) return false;
      const GroundCell& cell = terrain_.cell(static_cast<std::int32_t>(x + dx - terrain_.low_x()),
                                             static_cast<std::int32_t>(y + dy - terrain_.low_y()));
      if (cell.is_unknown()) return false;
      const std::int32_t s = nearest_surface(cell, height_mm, config_.lattice.reach_mm);
      if (s == kNoSurface || cell.state[s] != GroundState::carries) return false;
    }
  }
  return true;
}

/// All of a step; with `ahead_of_m` only what lies in front of that place, seen along the step.
bool GroundWayPlanner::carries(const Step& from, const Step& step, const rt::Vector3* ahead_of_m) const {
  const Motion& motion = path_.motions().motion(from.heading, step.motion);
  const auto shift_mm = static_cast<std::int32_t>(1e3 * (level_m_ - terrain_.level_m()));
  std::int32_t height_mm = from.height_mm + shift_mm;
  std::int64_t x = from.x;
  std::int64_t y = from.y;
  for (std::uint8_t i = 0; i < step.times; ++i) {
    for (const MotionStation& station : path_.motions().stations(motion)) {
      const std::int64_t sx = x + station.x;
      const std::int64_t sy = y + station.y;
      if (ahead_of_m != nullptr && (motion.x != 0 || motion.y != 0)) {
        const double along = (terrain_.middle_m(sx) - ahead_of_m->x) * motion.x +
                             (terrain_.middle_m(sy) - ahead_of_m->y) * motion.y;
        if (along < 0.0) continue;
      }
      if (terrain_.is_inside(sx, sy)) {
        const GroundCell& cell = terrain_.cell(static_cast<std::int32_t>(sx - terrain_.low_x()),
                                               static_cast<std::int32_t>(sy - terrain_.low_y()));
        const std::int32_t s =
            cell.is_unknown() ? kNoSurface : nearest_surface(cell, height_mm, config_.lattice.reach_mm);
        if (s != kNoSurface) height_mm = cell.height_mm[s];
      }
      if (!stands(sx, sy, height_mm, station.slot)) return false;
    }
    x += motion.x;
    y += motion.y;
  }
  return true;
}

/// Place in steps_ of the step that the robot drives; 0: it has not begun this way.
std::uint32_t GroundWayPlanner::driven() const {
  const bool is_on_it = progress_.series == output_.series && progress_.step > first_;
  return is_on_it ? std::min(progress_.step - first_, size_) : 0u;
}

void GroundWayPlanner::verify(const rt::Vector3& p_m) {
  if (size_ < 2) return;
  const std::uint32_t now = driven();
  for (std::uint32_t i = std::max(now, 1u); i < size_; ++i) {
    if (carries(steps_[i - 1], steps_[i], i == now ? &p_m : nullptr)) continue;
    output_.refused += size_ - i;
    cut(i);
    return;
  }
}

/// Keeps the first `steps`. What the robot is driving already cannot be kept: then all of it goes, and it
/// stops.
void GroundWayPlanner::cut(std::uint32_t steps) {
  if (steps <= std::max(driven(), 1u)) {
    drop_way();
    return;
  }
  size_ = steps;
  output_.whole = 0;
  if (is_planning_ && plan_from_ >= first_ + size_) is_planning_ = false;
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
    const double ux = (turn.cos * dx - turn.sin * dy) / length;
    const double uy = (turn.sin * dx + turn.cos * dy) / length;
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
                    (now >= plan_from_ && plan_from_ + 1 < first_ + size_)))
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

/// At the end of what is known the robot stands and looks. Ground that does not come into sight is given up,
/// and ways around it are looked for.
void GroundWayPlanner::wait_for_sight() {
  const bool at_end = size_ <= 1 || driven() >= size_;
  if (!at_end || !standing_ || cells_wait_ == 0) {
    waits_since_ns_ = -1;
    return;
  }
  if (waits_since_ns_ < 0) waits_since_ns_ = now_ns_;
  if (static_cast<double>(now_ns_ - waits_since_ns_) < 1e9 * config_.patience_s) return;
  waits_since_ns_ = -1;
  for (std::uint32_t i = 0; i < cells_wait_; ++i)
    terrain_.give_up(unseen_low_[0] + unseen_[i].x, unseen_low_[1] + unseen_[i].y);
  cells_wait_ = 0;
}

void GroundWayPlanner::end() {
  const bool drives = size_ > 1 && state_ != GroundWayState::arrived;
  output_.state = static_cast<std::uint32_t>(drives ? GroundWayState::driving : state_);
  output_.stamp_ns = now_ns_;
  output_.goal = progress_.goal;
  output_.first = first_;
  output_.steps = size_ > 1 ? size_ : 0;
  for (std::uint32_t i = 0; i < output_.steps; ++i) {
    const Step& step = steps_[i];
    const CellStep look = kHeadingSteps[static_cast<std::size_t>(step.heading)];
    output_.x_mm[i] = static_cast<std::int32_t>((2 * step.x + 1) * config_.lattice.cell_mm / 2);
    output_.y_mm[i] = static_cast<std::int32_t>((2 * step.y + 1) * config_.lattice.cell_mm / 2);
    const double heading = rt::atan2(look.y, look.x);
    output_.heading_mrad[i] = static_cast<std::int16_t>(rt::floor(1e3 * heading + 0.5));
    WayMotion kind = WayMotion::begin;
    if (i > 0) {
      const Motion& motion = path_.motions().motion(steps_[i - 1].heading, step.motion);
      kind = motion.x == 0 && motion.y == 0 ? WayMotion::turn
             : motion.reverse               ? WayMotion::reverse
                                            : WayMotion::forward;
    }
    output_.motion[i] = static_cast<std::uint8_t>(kind);
  }
}

bool GroundWayPlanner::is_consistent() const {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 40;
  const auto is_heading = [](std::int32_t heading) { return heading >= 0 && heading < kHeadings; };
  for (std::uint32_t i = 0; i < size_; ++i) {
    const Step& step = steps_[i];
    if (step.x < -kFarthest || step.x > kFarthest || step.y < -kFarthest || step.y > kFarthest ||
        !is_heading(step.heading) || step.motion >= kMotions || step.height_mm < -100'000 ||
        step.height_mm > 100'000)
      return false;
  }
  return state_ <= GroundWayState::none && std::fabs(level_m_) < 1e6 &&
         output_.steps <= GroundWay::kMostSteps;
}

void GroundWayPlanner::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "ground way planner")
      .fixed(config_, memory_, usable_)
      .by_hand(terrain_, path_, size_, cells_wait_)
      .scratch(progress_, standing_, now_ns_)
      .state(goal_, trusts_, state_, steps_, first_, level_m_, is_planning_, plan_start_, plan_goal_,
             plan_slices_, plan_from_, is_intermediate_, attempt_, unseen_, unseen_low_, waits_since_ns_,
             output_);
  archive.bounded(size_, GroundWay::kMostSteps);
  archive.bounded(cells_wait_, std::size(unseen_));
  archive.value(terrain_);
  if (archive.is_reading() && !is_consistent()) archive.fail(Status::malformed, "a way that is none");
  if (!archive.is_reading() || archive.status() != Status::ok || !is_planning_) return;
  // No plan lives for so long: its work is bounded by the lattice.
  constexpr std::uint32_t kMostSlices = 1'000'000;
  const std::uint32_t slices = plan_slices_ < kMostSlices ? plan_slices_ : kMostSlices;
  start_plan();
  for (; plan_slices_ < slices; ++plan_slices_) path_.run(terrain_.map(), kSlice);
}

}  // namespace sortie::planner
