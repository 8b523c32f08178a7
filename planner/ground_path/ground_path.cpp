// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/ground_path.hpp"

#include <algorithm>

namespace sortie::planner {
namespace {

// Weights of the distance to the goal, 1/16, round by round; the last one stays.
constexpr std::uint32_t kWeights[] = {32, 24, 20, 18, 16};

}  // namespace

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
  if (!is_live()) return state_;
  if (map.version() != map_version_ || map.nx() != config_.nx || map.ny() != config_.ny) {
    way_steps_ = drivable_steps_ = 0;
    best_ = UINT32_MAX;
    return state_ = GroundPathState::outdated;
  }
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
  const std::uint32_t place = 2 * static_cast<std::uint32_t>(map.index(start_.x, start_.y)) +
                              static_cast<std::uint32_t>(start_.surface);
  const std::uint32_t node = columns_.reach(place) + static_cast<std::uint32_t>(start_.heading);
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
  weight_ = kWeights[0];
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
    const std::uint32_t place =
        2 * static_cast<std::uint32_t>(map.index(x, y)) + static_cast<std::uint32_t>(surface);
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
  weight_ = kWeights[std::min<std::size_t>(round_, std::size(kWeights) - 1)];
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

// Copies the way to a node. Poses on it may have become cheaper since: it costs what its motions cost.
void GroundPath::show(const GroundMap& map, std::uint32_t last) {
  std::size_t steps = 1;
  std::uint32_t total = 0;
  for (std::uint32_t n = last; columns_[n].parent != kNoPlace; n = columns_[n].parent, ++steps) {
    const GroundPose from = pose_of(map, columns_[n].parent);
    total += attempt(map, from, motions_.motion(from.heading, columns_[n].motion)).cost;
  }
  work_.units += steps;
  ++work_.improved;
  best_ = total;
  is_whole_ = steps <= way_.size();
  way_steps_ = drivable_steps_ = std::min(steps, way_.size());
  std::uint32_t paid = total;
  for (std::uint32_t n = last; steps > 0; --steps) {
    const GroundNode& node = columns_[n];
    GroundStep step{pose_of(map, n), paid, node.motion, true};
    if (node.parent != kNoPlace) {
      const GroundPose from = pose_of(map, node.parent);
      const Try tried = attempt(map, from, motions_.motion(from.heading, node.motion));
      step.is_known = tried.is_known;
      paid -= tried.cost;
      n = node.parent;
    } else {
      step.is_known = prices_.price(map, step.pose.x, step.pose.y, step.pose.surface, step.pose.heading,
                                    work_.units) != kUnknownStand;
    }
    if (steps <= way_.size()) way_[steps - 1] = step;
    if (!step.is_known && steps <= way_.size()) drivable_steps_ = steps - 1;
  }
}

std::size_t GroundPath::unseen(const GroundMap& map, std::span<CellStep> cells) const {
  if (drivable_steps_ == way_steps_) return 0;
  const GroundStep& step = way_[drivable_steps_];
  std::size_t count = 0;
  const auto add = [&](std::int32_t x, std::int32_t y, std::int32_t slot) {
    const std::int32_t reach = footprints().reach(slot);
    for (std::int32_t dy = -reach; dy <= reach; ++dy) {
      const FootprintRow& row = footprints().row(slot, dy);
      for (std::int32_t dx = row.low; dx <= row.high; ++dx) {
        const CellStep cell{x + dx, y + dy};
        if (count == cells.size() || !map.is_inside(cell.x, cell.y)) continue;
        if (!map.cell(cell.x, cell.y).is_unknown()) continue;
        const auto end = cells.begin() + static_cast<std::ptrdiff_t>(count);
        if (std::find(cells.begin(), end, cell) == end) cells[count++] = cell;
      }
    }
  };
  if (drivable_steps_ == 0) {
    add(step.pose.x, step.pose.y, step.pose.heading);
    return count;
  }
  const GroundPose& from = way_[drivable_steps_ - 1].pose;
  for (const MotionStation& station : motions_.stations(motions_.motion(from.heading, step.motion)))
    add(from.x + station.x, from.y + station.y, station.slot);
  return count;
}

}  // namespace sortie::planner
