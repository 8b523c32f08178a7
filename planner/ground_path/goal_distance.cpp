// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/goal_distance.hpp"

#include <algorithm>

namespace sortie::planner {
GoalDistance::GoalDistance(const GroundPathConfig& config, const MotionTable& motions,
                           const DistanceMemory& memory)
    : reach_mm_(config.reach_mm),
      over_unknown_(config.unknown != UnknownGround::blocked),
      unknown_price_(config.unknown_price),
      nodes_(memory.nodes) {
  std::size_t count = 0;
  const auto add = [&](std::int32_t x, std::int32_t y, std::uint32_t ms) {
    edges_[count++] = {static_cast<std::int8_t>(x), static_cast<std::int8_t>(y), ms};
  };
  for (std::int32_t h = 0; h < kHeadings; ++h) {
    const CellStep step = kHeadingSteps[static_cast<std::size_t>(h)];
    add(step.x, step.y, motions.step_ms(h));
  }
  // Curves whose corner is not on ground; most end where straight steps have been before. Backwards they
  // reach what those of the heading opposite reach forwards.
  for (std::int32_t h = 0; h < kHeadings; ++h) {
    for (const std::int32_t turn : {1, 2}) {
      const std::int32_t last = wrap_heading(h + turn);
      const CellStep a = curve_leg(h);
      const CellStep b = curve_leg(last);
      add(a.x + b.x, a.y + b.y, motions.leg_ms(h) + motions.leg_ms(last));
    }
  }
  width_ = kCostPerMs * motions.step_ms(0);
}

void GoalDistance::begin(const GroundMap& map, const GroundPose& goal, const GroundPose& start) {
  cleared_ = 0;
  first_.fill(kNone);
  bucket_ = queued_ = 0;
  limit_ = kNone;
  is_start_reached_ = is_cut_ = false;
  start_ = map.place(start.x, start.y, start.surface);
  goal_ = map.place(goal.x, goal.y, goal.surface);
}

void GoalDistance::put(std::uint32_t place, std::uint32_t cost) {
  std::uint32_t& first = first_[cost / width_ % kBuckets];
  nodes_[place] = {cost, kNone, first};
  if (first != kNone) nodes_[first].before = place;
  first = place;
  ++queued_;
}

void GoalDistance::take(std::uint32_t place) {
  const DistanceNode& node = nodes_[place];
  if (node.before != kNone)
    nodes_[node.before].after = node.after;
  else
    first_[node.cost / width_ % kBuckets] = node.after;
  if (node.after != kNone) nodes_[node.after].before = node.before;
  --queued_;
}

bool GoalDistance::step(const GroundMap& map, StandPrices& prices, std::uint64_t& units) {
  units += 1;
  if (cleared_ < nodes_.size()) {
    constexpr std::size_t kClearedAtOnce = 1024;
    const auto rest = nodes_.subspan(cleared_, std::min(kClearedAtOnce, nodes_.size() - cleared_));
    std::fill(rest.begin(), rest.end(), DistanceNode{kNone, kNone, kNone});
    cleared_ += rest.size();
    units += rest.size() / 64;
    if (cleared_ == nodes_.size()) put(goal_, 0);
    return true;
  }
  if (queued_ == 0) return false;
  const std::uint32_t place = first_[bucket_ % kBuckets];
  if (place == kNone) {
    ++bucket_;
    // What is not settled is at least as far as the next bucket begins.
    if (std::uint64_t{bucket_} * width_ < limit_) return true;
    return false;
  }
  take(place);
  units += kUnitsPerNode - 1;
  if (place == start_) {
    is_start_reached_ = true;
    const std::uint32_t cost = nodes_[place].cost;
    limit_ = cost + cost / 4 + 8 * width_;
  }
  const auto cell = static_cast<std::int32_t>(place / 2);
  Place from{cell % map.nx(), cell / map.nx(), kNoHeight, nodes_[place].cost, kCostPerMs};
  const GroundCell& here = map.cell(from.x, from.y);
  if (!here.is_unknown()) from.height_mm = here.height_mm[place % 2];
  // All that comes here ends here, at this price or more; but hardly seen ground has a price of its own.
  const std::uint8_t least = prices.least(from.x, from.y, static_cast<std::int32_t>(place % 2));
  from.per_ms += over_unknown_ ? std::min(least, unknown_price_) : least;
  for (const Edge& edge : edges_) relax(map, prices, from, edge, units);
  return true;
}

void GoalDistance::relax(const GroundMap& map, StandPrices& prices, const Place& from, const Edge& edge,
                         std::uint64_t& units) {
  const std::int32_t x = from.x + edge.x;
  const std::int32_t y = from.y + edge.y;
  if (!map.is_inside(x, y)) return;
  const std::uint32_t cost = from.cost + edge.ms * from.per_ms;
  const GroundCell& there = map.cell(x, y);
  const std::int32_t surfaces = there.state[1] == GroundState::unknown ? 1 : 2;
  for (std::int32_t s = 0; s < surfaces; ++s) {
    const std::uint32_t to = map.place(x, y, s);
    if (nodes_[to].cost <= cost) continue;
    if (from.height_mm != kNoHeight && !there.is_unknown()) {
      const std::int32_t apart = there.height_mm[s] - from.height_mm;
      if (apart > reach_mm_ || -apart > reach_mm_) continue;
    }
    const std::uint8_t stands = prices.price(map, x, y, s, FootprintTable::kCore, units);
    if (stands == kBlockedStand || (stands == kUnknownStand && !over_unknown_)) continue;
    if (cost > kMostCost) {
      is_cut_ = true;
      continue;
    }
    if (nodes_[to].cost != kNone) take(to);
    put(to, cost);
  }
}

}  // namespace sortie::planner
