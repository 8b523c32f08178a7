// SPDX-License-Identifier: BSD-3-Clause
// A job of the planner of ways: what is known of the robot, what was handed out, and when to plan.
#include "planner/ground_way/ground_way_planner.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner {

namespace {

constexpr double kFarthestWay_m = 1e5;

std::int32_t mm_apart(std::int32_t v) { return v < 0 ? -v : v; }

}  // namespace

GroundWayPlanner::GroundWayPlanner(const GroundWayConfig& config, std::int32_t elevation_cell_mm,
                                   rt::Arena& arena)
    : config_(config),
      terrain_(config.lattice, config.rules, elevation_cell_mm, arena),
      memory_(GroundPathMemory::take(arena, config.lattice, config.columns, config.open, 1024)),
      path_(config.lattice, terrain_.prices(), memory_),
      usable_(terrain_.usable() && arena.refused() == 0 &&
              3 * config.lattice.nx / 8 > path_.footprints().reach() + 2 &&
              3 * config.lattice.ny / 8 > path_.footprints().reach() + 2) {}

Status GroundWayPlanner::begin(const mapping::ElevationView& view, const rt::PoseEstimate& pose,
                               bool standing, const GroundWayProgress& progress, rt::Nanoseconds heights_ns,
                               rt::Nanoseconds now_ns) {
  progress_ = progress;
  adopted_ = false;
  standing_ = standing;
  now_ns_ = now_ns;
  const rt::Vector3 p_m = rt::to_vector(pose.p_world_body_m);
  const rt::Quaternion q = rt::to_quaternion(pose.q_world_body);
  const auto is_place = [](double m) { return std::fabs(m) <= kFarthestWay_m; };
  const bool is_told = progress.goal != 0;
  Status status = Status::ok;
  if (!is_place(p_m.x) || !is_place(p_m.y) || !is_place(p_m.z) || !rt::is_finite(q) ||
      (is_told && !(is_place(progress.goal_m[0]) && is_place(progress.goal_m[1])))) {
    status = Status::not_finite;
  } else if (static_cast<double>(now_ns - heights_ns) > 1e9 * config_.most_heights_age_s || pose.flags == 0 ||
             static_cast<double>(now_ns - pose.stamp_ns) > 1e9 * config_.most_pose_age_s) {
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
  // Whoever else drives brings the robot to where no step begins.
  if (status != Status::ok || !usable_ || !is_told || !progress.in_control) {
    drop_way();
    state_ = is_told ? GroundWayState::waiting : GroundWayState::idle;
    return status;
  }
  const rt::SinCos yaw = rt::sincos(rt::yaw_of(q));
  const rt::Vector3 up = rt::rotate(q, {0.0, 0.0, 1.0});
  const double steep = up.z > 0.5 ? 1.0 / up.z : 0.0;  // beyond 60 degrees nobody drives
  const GroundStance stance{p_m, yaw.cos, yaw.sin, -up.x * steep, -up.y * steep};
  p_m_ = p_m;
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

/// True where all cells that a slot needs carry, by the newest heights.
bool GroundWayPlanner::stands(std::int64_t x, std::int64_t y, std::int32_t height_mm,
                              std::int32_t slot) const {
  const FootprintTable& footprints = path_.footprints();
  const std::int32_t reach = footprints.reach(slot);
  std::int32_t row_mm[2 * FootprintTable::kMostReach + 1];
  std::fill(std::begin(row_mm), std::end(row_mm), kNoHeight);
  for (std::int32_t dy = -reach; dy <= reach; ++dy) {
    const FootprintRow& row = footprints.row(slot, dy);
    std::int32_t left_mm = 0;
    for (std::int32_t dx = row.low; dx <= row.high; ++dx) {
      if (!terrain_.is_inside(x + dx, y + dy)) return false;
      const GroundCell& cell = terrain_.cell(static_cast<std::int32_t>(x + dx - terrain_.low_x()),
                                             static_cast<std::int32_t>(y + dy - terrain_.low_y()));
      if (cell.is_unknown()) return false;
      const std::int32_t s = nearest_surface(cell, height_mm, config_.lattice.reach_mm);
      if (s == kNoSurface || cell.state[s] != GroundState::carries) return false;
      // No step under the robot either, whatever was said of the cells that it stands on.
      const std::int32_t mine_mm = cell.height_mm[s];
      if (dx > row.low && mm_apart(mine_mm - left_mm) > terrain_.step_mm()) return false;
      std::int32_t& below_mm = row_mm[dx + reach];
      if (below_mm != kNoHeight && mm_apart(mine_mm - below_mm) > terrain_.step_mm()) return false;
      left_mm = below_mm = mine_mm;
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
  // A plan of several jobs was made over the heights of the first: what is new is looked at before it goes
  // out.
  if (adopted_) verify(p_m_);
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
  for (const CellStep& cell : unseen_)
    if (cell.x < -10'000 || cell.x > 10'000 || cell.y < -10'000 || cell.y > 10'000) return false;
  for (const std::int64_t low : unseen_low_)
    if (low < -kFarthest || low > kFarthest) return false;
  if (waits_since_ns_ < -1 || waits_since_ns_ > std::int64_t{1} << 62) return false;
  return state_ <= GroundWayState::none && std::fabs(level_m_) < 1e6 &&
         output_.steps <= GroundWay::kMostSteps;
}

void GroundWayPlanner::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "ground way planner")
      .fixed(config_, memory_, usable_)
      .by_hand(terrain_, path_, size_, cells_wait_)
      .scratch(progress_, standing_, now_ns_, p_m_, adopted_)
      .state(goal_, trusts_, state_, steps_, first_, level_m_, is_planning_, plan_start_, plan_goal_,
             plan_slices_, plan_from_, is_intermediate_, attempt_, unseen_, unseen_low_, waits_since_ns_,
             output_);
  archive.bounded(size_, GroundWay::kMostSteps);
  archive.bounded(cells_wait_, std::size(unseen_));
  archive.value(terrain_);
  if (archive.is_reading() && !is_consistent()) archive.fail(Status::malformed, "a way that is none");
  if (!archive.is_reading() || archive.status() != Status::ok || !is_planning_) return;
  // No plan lives for so long: its work is bounded by the lattice.
  constexpr std::uint32_t kMostSlices = 20'000;
  const std::uint32_t slices = plan_slices_ < kMostSlices ? plan_slices_ : kMostSlices;
  start_plan();
  for (; plan_slices_ < slices; ++plan_slices_) path_.run(terrain_.map(), kSlice);
}

}  // namespace sortie::planner
