// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/ground_path.hpp"

#include <algorithm>

namespace sortie::planner {

GroundPathMemory GroundPathMemory::take(rt::Arena& arena, const GroundPathConfig& config, std::size_t columns,
                                        std::size_t open, std::size_t steps) {
  const std::size_t surfaces = check(config) == Status::ok ? 2 * GroundMap::cells_for(config) : 0;
  columns = std::min(columns, surfaces);
  GroundPathMemory memory;
  memory.prices = arena.make_array<std::uint8_t>("ground path: prices",
                                                 surfaces == 0 ? 0 : StandPrices::bytes_for(config));
  memory.distances.nodes = arena.make_array<DistanceNode>("ground path: distances", surfaces);
  memory.columns.columns = arena.make_array<std::uint32_t>("ground path: columns", surfaces);
  memory.columns.nodes = arena.make_array<GroundNode>("ground path: poses", columns * kHeadings);
  memory.columns.places = arena.make_array<std::uint32_t>("ground path: places", columns);
  memory.heap =
      arena.make_array<std::uint32_t>("ground path: open list", std::min(open, columns * kHeadings));
  memory.way = arena.make_array<GroundStep>("ground path: way", steps);
  return memory;
}

GroundPath::GroundPath(const GroundPathConfig& config, const PostureSource& source,
                       const GroundPathMemory& memory)
    : config_(config),
      motions_(config),
      prices_(config, source, memory.prices),
      distances_(config, motions_, memory.distances),
      columns_(memory.columns),
      heap_(memory.heap),
      heap_capacity_(static_cast<std::uint32_t>(std::min<std::size_t>(memory.heap.size(), kNoPlace))),
      way_(memory.way) {
  if (check(config) != Status::ok || !motions_.is_whole()) return;
  const std::size_t surfaces = 2 * GroundMap::cells_for(config);
  usable_ = memory.prices.size() >= StandPrices::bytes_for(config) &&
            memory.distances.nodes.size() >= surfaces && memory.columns.columns.size() >= surfaces &&
            memory.columns.nodes.size() >= kHeadings && !memory.columns.places.empty() &&
            !memory.heap.empty() && !memory.way.empty();
}

GroundPathState GroundPath::begin(const GroundMap& map, const GroundPose& start, const GroundPose& goal) {
  way_steps_ = drivable_steps_ = 0;
  is_whole_ = is_cut_ = false;
  best_ = UINT32_MAX;
  lower_ = 0;
  granted_ = 0;
  work_ = {};
  start_ = start;
  goal_ = goal;
  if (!usable_ || map.nx() != config_.nx || map.ny() != config_.ny)
    return state_ = GroundPathState::bad_memory;
  map_version_ = map.version();
  columns_.clear();
  heap_.clear();
  opened_ = round_ = 0;
  phase_ = Phase::refresh;
  return state_ = GroundPathState::running;
}

GroundPathState GroundPath::run(GroundMap& map, std::uint64_t units) {
  if (state_ == GroundPathState::idle || state_ == GroundPathState::bad_memory) return state_;
  if (map.version() != map_version_ || map.nx() != config_.nx || map.ny() != config_.ny) {
    way_steps_ = drivable_steps_ = 0;
    best_ = UINT32_MAX;
    return state_ = GroundPathState::outdated;
  }
  if (!is_live()) return state_;
  granted_ += std::min(units, UINT64_MAX - granted_);
  while (is_live() && work_.units < granted_) step(map);
  return state_;
}

void GroundPath::step(GroundMap& map) {
  switch (phase_) {
    case Phase::refresh:
      if (!prices_.refresh(map, work_.units)) phase_ = Phase::judge;
      break;
    case Phase::judge:
      judge_ends(map);
      break;
    case Phase::measure:
      if (distances_.step(map, prices_, work_.units)) break;
      if (distances_.is_start_reached()) {
        phase_ = Phase::search;
      } else {
        state_ = distances_.is_cut() ? GroundPathState::too_far : GroundPathState::none;
      }
      break;
    case Phase::search:
      search(map);
      break;
    case Phase::repair:
      repair();
      break;
  }
}

void GroundPath::judge_ends(const GroundMap& map) {
  using State = GroundPathState;
  work_.units += 1;
  const auto is_there = [&map](const GroundPose& p) {
    if (!map.is_inside(p.x, p.y) || p.surface < 0 || p.surface > 1) return false;
    const GroundCell& cell = map.cell(p.x, p.y);
    return cell.state[p.surface] != GroundState::unknown || (cell.is_unknown() && p.surface == 0);
  };
  const auto stand = [&](const GroundPose& p, std::int32_t heading) {
    const std::uint8_t price = prices_.price(map, p.x, p.y, p.surface, heading, work_.units);
    return price == kUnknownStand && config_.unknown != UnknownGround::blocked ? std::uint8_t{0} : price;
  };
  state_ = State::start_outside;
  if (!is_there(start_) || start_.heading < 0 || start_.heading >= kHeadings) return;
  state_ = State::goal_outside;
  if (!is_there(goal_) || goal_.heading < kAnyHeading || goal_.heading >= kHeadings) return;
  const std::uint8_t at_start = stand(start_, start_.heading);
  state_ = at_start == kBlockedStand ? State::start_blocked : State::start_unknown;
  if (at_start > kMostPrice) return;
  std::uint8_t at_goal = kBlockedStand;
  for (std::int32_t h = 0; h < kHeadings; ++h)
    if (goal_.heading == kAnyHeading || goal_.heading == h) at_goal = std::min(at_goal, stand(goal_, h));
  state_ = at_goal == kBlockedStand ? State::goal_blocked : State::goal_unknown;
  if (at_goal > kMostPrice) return;
  state_ = State::running;
  const std::uint32_t node = columns_.reach(map.place(start_.x, start_.y, start_.surface)) +
                             static_cast<std::uint32_t>(start_.heading);
  columns_[node].cost = 0;
  if (is_goal(start_)) {
    best_ = 0;
    show(map, node);
    state_ = State::proved;
    return;
  }
  distances_.begin(map, goal_, start_);
  round_ = 1;
  work_.rounds = 1;
  weight_ = kFirstWeight;
  phase_ = Phase::measure;
  open(node, 0);  // the only one: any estimate will do
}

bool GroundPath::is_goal(const GroundPose& pose) const {
  return pose.x == goal_.x && pose.y == goal_.y && pose.surface == goal_.surface &&
         (goal_.heading == kAnyHeading || pose.heading == goal_.heading);
}

GroundPose GroundPath::pose_of(const GroundMap& map, std::uint32_t node) const {
  const std::uint32_t place = columns_.place_of(node);
  const auto cell = static_cast<std::int32_t>(place / 2);
  return {cell % map.nx(), cell / map.nx(), static_cast<std::int32_t>(place % 2),
          static_cast<std::int32_t>(node % kHeadings)};
}

}  // namespace sortie::planner
