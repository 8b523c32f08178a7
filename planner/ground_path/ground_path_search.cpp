// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/ground_path.hpp"

#include <algorithm>

namespace sortie::planner {
namespace {

// Weights of the distance to the goal, 1/16, of the rounds behind the first; the last one stays.
constexpr std::uint32_t kWeights[] = {24, 20, 18, 16};

}  // namespace

void GroundPath::open(std::uint32_t node, std::uint32_t to_goal) {
  GroundNode& n = columns_[node];
  n.is_inconsistent = false;
  n.estimate = n.cost + static_cast<std::uint32_t>(std::uint64_t{weight_} * to_goal / 16);
  if (n.heap_place != kNoPlace) {
    heap_.move_up(n.heap_place, *this);
  } else if (opened_ == heap_capacity_) {
    state_ = GroundPathState::open_full;
  } else {
    ++opened_;
    heap_.push(node, *this);
  }
}

void GroundPath::search(const GroundMap& map) {
  work_.units += kExpandUnits;
  if (opened_ == 0) {
    end_round();
    return;
  }
  const std::uint32_t node = heap_.pop(*this);
  --opened_;
  if (columns_[node].estimate >= best_) {  // and all others are too
    columns_[node].is_inconsistent = true;
    end_round();
    return;
  }
  expand(map, node);
}

void GroundPath::expand(const GroundMap& map, std::uint32_t node) {
  const GroundPose from = pose_of(map, node);
  const std::uint32_t cost = columns_[node].cost;
  columns_[node].closed_round = static_cast<std::uint8_t>(round_);
  ++work_.expanded;
  for (std::uint32_t i = 0; i < kMotions && is_live(); ++i) {
    const Motion& motion = motions_.motion(from.heading, i);
    const std::int32_t x = from.x + motion.x;
    const std::int32_t y = from.y + motion.y;
    if (!map.is_inside(x, y)) continue;
    // Most ends have been reached as cheaply before, whatever the ground costs.
    const std::uint32_t least = cost + kCostPerMs * motion.time_ms;
    const GroundCell& cell = map.cell(x, y);
    const GroundCell& here = map.cell(from.x, from.y);
    const std::int32_t height_mm = here.is_unknown() ? kNoHeight : here.height_mm[from.surface];
    const std::int32_t surface = cell.is_unknown() ? 0 : nearest_surface(cell, height_mm, config_.reach_mm);
    if (surface == kNoSurface) continue;
    const std::uint32_t place = map.place(x, y, surface);
    const std::uint32_t column = columns_.find(place);
    if (column != kNoPlace && columns_[column + motion.heading].cost <= least) continue;
    if (least + distances_.cost(place) >= best_) continue;
    const Try tried = attempt(map, from, motion);
    if (tried.cost == UINT32_MAX) continue;
    if (cost + tried.cost > kMostCost) {
      is_cut_ = true;
      continue;
    }
    reach(map, node, i, place, cost + tried.cost);
  }
}

// Whether a motion stands all along, and what it costs: its time at the worst price on the way.
GroundPath::Try GroundPath::attempt(const GroundMap& map, const GroundPose& from, const Motion& motion) {
  const GroundCell& here = map.cell(from.x, from.y);
  const std::int32_t height_mm = here.is_unknown() ? kNoHeight : here.height_mm[from.surface];
  Try result;
  std::uint8_t worst = 0;
  for (const MotionStation& station : motions_.stations(motion)) {
    const std::int32_t x = from.x + station.x;
    const std::int32_t y = from.y + station.y;
    if (!map.is_inside(x, y)) return {};
    const GroundCell& cell = map.cell(x, y);
    const std::int32_t surface = cell.is_unknown() ? 0 : nearest_surface(cell, height_mm, config_.reach_mm);
    if (surface == kNoSurface) return {};
    std::uint8_t price = prices_.price(map, x, y, surface, station.slot, work_.units);
    if (price == kBlockedStand) return {};
    if (price == kUnknownStand) {
      if (config_.unknown == UnknownGround::blocked) return {};
      result.is_known = false;
      price = config_.unknown_price;
    }
    worst = std::max(worst, price);
  }
  result.cost = motion.time_ms * (kCostPerMs + worst);
  if (!result.is_known && config_.unknown == UnknownGround::look_first &&
      prices_.price(map, from.x, from.y, from.surface, from.heading, work_.units) != kUnknownStand)
    result.cost += kCostPerMs * static_cast<std::uint32_t>(config_.look_ms);
  return result;
}

void GroundPath::reach(const GroundMap& map, std::uint32_t from, std::uint32_t motion, std::uint32_t place,
                       std::uint32_t cost) {
  const std::uint32_t column = columns_.reach(place);
  if (column == kNoPlace) {
    state_ = GroundPathState::capacity;
    return;
  }
  const std::uint32_t node =
      column + motions_.motion(static_cast<std::int32_t>(from % kHeadings), motion).heading;
  GroundNode& n = columns_[node];
  if (cost >= n.cost) return;
  n.cost = cost;
  n.parent = from;
  n.motion = static_cast<std::uint8_t>(motion);
  if (is_goal(pose_of(map, node))) {
    if (cost < best_) {
      best_ = cost;
      state_ = GroundPathState::found;
      show(map, node);
    }
  } else if (n.closed_round == round_) {
    n.is_inconsistent = true;
  } else {
    open(node, distances_.cost(place));
  }
}

void GroundPath::end_round() {
  if (best_ == UINT32_MAX) {
    state_ = is_cut_ ? GroundPathState::too_far : GroundPathState::none;
    return;
  }
  weight_ = kWeights[std::min<std::size_t>(round_ - 1, std::size(kWeights) - 1)];
  heap_.clear();
  opened_ = 0;
  repaired_ = 0;
  least_ = UINT32_MAX;
  phase_ = Phase::repair;
}

// Puts what is open, and what became cheaper after it had been opened, in the order of the next weight; all
// that cannot lead to a cheaper way is dropped.
void GroundPath::repair() {
  if (repaired_ == columns_.size()) {
    lower_ = std::max(lower_, std::min(least_, best_));
    if (least_ >= best_) {
      state_ = GroundPathState::proved;
      return;
    }
    round_ = std::min<std::uint32_t>(round_ + 1, UINT8_MAX);
    ++work_.rounds;
    phase_ = Phase::search;
    return;
  }
  const std::uint32_t to_goal = distances_.cost(columns_.place_of(repaired_));
  work_.units += kRepairUnits;
  for (const std::uint32_t end = repaired_ + kHeadings; repaired_ < end && is_live(); ++repaired_) {
    GroundNode& n = columns_[repaired_];
    const bool waits = n.heap_place != kNoPlace || n.is_inconsistent;
    n.heap_place = kNoPlace;
    n.is_inconsistent = false;
    if (!waits || n.cost + to_goal >= best_) continue;
    work_.units += kRepairUnits;
    least_ = std::min(least_, n.cost + to_goal);
    open(repaired_, to_goal);
  }
}

}  // namespace sortie::planner
