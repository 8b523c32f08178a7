// SPDX-License-Identifier: BSD-3-Clause
// The twin of the ground planner: Dijkstra's algorithm over all poses of the lattice, and a walk along a way
// with the robot's true outline.
#pragma once

#include <cmath>
#include <functional>
#include <queue>
#include <vector>

#include "tests/planner/ground_rig.hpp"

namespace sortie::planner::test {

/// Exhaustive search. It shares the tables of motions and footprints, which define the lattice, and nothing
/// else; it looks at every cell of every station of every motion.
class GroundTwin {
 public:
  static constexpr std::uint64_t kNoWay = UINT64_MAX;

  explicit GroundTwin(OwnedGround& ground)
      : g_(ground), stands_(ground.cells.size() * 2 * kStandSlots, kNotLookedAt) {}

  /// The cheapest way's cost, or kNoWay.
  std::uint64_t optimum(const GroundPose& start, const GroundPose& goal) {
    std::vector<std::uint64_t> costs(g_.cells.size() * 2 * kHeadings, kNoWay);
    using Entry = std::pair<std::uint64_t, std::size_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    if (stand(start) < 0) return kNoWay;
    costs[number(start)] = 0;
    open.push({0, number(start)});
    while (!open.empty()) {
      const auto [cost, i] = open.top();
      open.pop();
      if (cost != costs[i]) continue;
      const auto h = static_cast<std::int32_t>(i % kHeadings);
      const auto cell = static_cast<std::int32_t>(i / kHeadings / 2);
      const GroundPose pose{cell % g_.config.nx, cell / g_.config.nx,
                            static_cast<std::int32_t>(i / kHeadings % 2), h};
      GroundPose there = pose;
      there.heading = goal.heading == kAnyHeading ? kAnyHeading : h;
      if (there == goal) return cost;
      for (std::uint32_t m = 0; m < kMotions; ++m) {
        GroundPose end;
        const std::int64_t paid = motion_cost(pose, g_.path.motions().motion(h, m), end);
        if (paid < 0) continue;
        const std::uint64_t sum = cost + static_cast<std::uint64_t>(paid);
        if (sum >= costs[number(end)]) continue;
        costs[number(end)] = sum;
        open.push({sum, number(end)});
      }
    }
    return kNoWay;
  }

  /// What it costs to stand there; below 0 where nobody can, or may because it was not seen.
  std::int32_t stand(const GroundPose& p) {
    const std::int32_t known = price(p.x, p.y, p.surface, p.heading);
    return known == kUnseen && g_.config.unknown == UnknownGround::blocked ? -1 : known;
  }

  /// What a motion costs, negative where it cannot be.
  std::int64_t motion_cost(const GroundPose& from, const Motion& motion, GroundPose& end) {
    std::int32_t worst = 0;
    bool unknown = false;
    for (const MotionStation& station : g_.path.motions().stations(motion)) {
      end = {from.x + station.x, from.y + station.y, surface(from, from.x + station.x, from.y + station.y),
             motion.heading};
      if (end.surface < 0) return -1;
      std::int32_t p = price(end.x, end.y, end.surface, station.slot);
      if (p < 0) return -1;
      if (p == kUnseen) {
        if (g_.config.unknown == UnknownGround::blocked) return -1;
        unknown = true;
        p = g_.config.unknown_price;
      }
      worst = std::max(worst, p);
    }
    std::int64_t cost = std::int64_t{motion.time_ms} * (16 + worst);
    const bool looks = g_.config.unknown == UnknownGround::look_first && unknown &&
                       price(from.x, from.y, from.surface, from.heading) != kUnseen;
    if (looks) cost += 16 * g_.config.look_ms;
    return cost;
  }

 private:
  static constexpr std::int32_t kUnseen = 1000;
  static constexpr std::int32_t kNotLookedAt = -2;

  std::size_t number(const GroundPose& p) const {
    return (2 * g_.map.index(p.x, p.y) + static_cast<std::size_t>(p.surface)) * kHeadings +
           static_cast<std::size_t>(p.heading);
  }
  // The surface of a cell on which a robot comes from a pose.
  std::int32_t surface(const GroundPose& from, std::int32_t x, std::int32_t y) const {
    if (!g_.map.is_inside(x, y)) return -1;
    const GroundCell& here = g_.map.cell(from.x, from.y);
    const GroundCell& cell = g_.map.cell(x, y);
    const bool known[2] = {cell.state[0] != GroundState::unknown, cell.state[1] != GroundState::unknown};
    if (!known[0] && !known[1]) return 0;
    if (here.state[from.surface] == GroundState::unknown) return known[0] ? 0 : 1;
    std::int32_t best = -1;
    double nearest = g_.config.reach_mm + 0.5;
    for (const int s : {0, 1}) {
      const double apart = std::abs(cell.height_mm[s] - here.height_mm[from.surface]);
      if (known[s] && apart < nearest) {
        best = s;
        nearest = apart;
      }
    }
    return best;
  }
  // -1 blocked, kUnseen, or the price.
  std::int32_t price(std::int32_t x, std::int32_t y, std::int32_t s, std::int32_t slot) {
    std::int32_t& kept = stands_[(2 * g_.map.index(x, y) + static_cast<std::size_t>(s)) * kStandSlots +
                                 static_cast<std::size_t>(slot)];
    if (kept == kNotLookedAt) kept = look(x, y, s, slot);
    return kept;
  }
  std::int32_t look(std::int32_t x, std::int32_t y, std::int32_t s, std::int32_t slot) {
    const GroundCell& middle = g_.map.cell(x, y);
    bool unseen = false;
    if (middle.state[s] == GroundState::unknown && (s == 1 || middle.state[1] != GroundState::unknown))
      return -1;
    for (std::int32_t dy = -20; dy <= 20; ++dy) {
      for (std::int32_t dx = -20; dx <= 20; ++dx) {
        const FootprintRow& row = g_.path.footprints().row(slot, dy);
        if (dx < row.low || dx > row.high) continue;
        const std::int32_t reach = g_.path.footprints().reach(slot);
        if (!g_.map.is_inside(x - reach, y - reach) || !g_.map.is_inside(x + reach, y + reach)) return -1;
        const GroundCell& cell = g_.map.cell(x + dx, y + dy);
        if (cell.state[0] == GroundState::unknown && cell.state[1] == GroundState::unknown) {
          unseen = true;
          continue;
        }
        if (middle.state[s] == GroundState::unknown) {
          if (cell.state[0] != GroundState::carries && cell.state[1] != GroundState::carries) return -1;
          continue;
        }
        const std::int32_t there = surface({x, y, s, 0}, x + dx, y + dy);
        if (there < 0 || cell.state[there] != GroundState::carries) return -1;
      }
    }
    if (unseen) return kUnseen;
    if (slot < kHeadings) return posture(x, y, s, slot);
    const std::int32_t a = posture(x, y, s, slot - kHeadings);
    const std::int32_t b = posture(x, y, s, (slot - kHeadings + 1) % kHeadings);
    return a < 0 || b < 0 ? -1 : std::max(a, b);
  }
  std::int32_t posture(std::int32_t x, std::int32_t y, std::int32_t s, std::int32_t heading) {
    const std::int32_t p = g_.posture(x, y, s, heading);
    return p == kBlockedStand ? -1 : std::min<std::int32_t>(p, kMostPrice);
  }

  OwnedGround& g_;
  std::vector<std::int32_t> stands_;
};

/// Where the robot truly is at a share of a motion, cells and radians.
struct OutlinePose {
  double x{};
  double y{};
  double yaw{};
};

inline OutlinePose outline_at(const GroundPose& from, const Motion& motion, double share) {
  const auto angle = [](std::int32_t h) {
    const CellStep step = kHeadingSteps[static_cast<std::size_t>(h)];
    return std::atan2(static_cast<double>(step.y), static_cast<double>(step.x));
  };
  const double first = angle(from.heading);
  if (motion.x == 0 && motion.y == 0) {
    const double turn = std::remainder(angle(motion.heading) - first, 2 * M_PI);
    return {static_cast<double>(from.x), static_cast<double>(from.y), first + share * turn};
  }
  if (motion.heading == from.heading) return {from.x + share * motion.x, from.y + share * motion.y, first};
  const CellStep leg = curve_leg(from.heading);
  const double sign = motion.reverse ? -1.0 : 1.0;
  const double cx = sign * leg.x;
  const double cy = sign * leg.y;
  const double a = 2 * share * (1 - share);
  const double b = share * share;
  const double dx = (1 - share) * cx + share * (motion.x - cx);
  const double dy = (1 - share) * cy + share * (motion.y - cy);
  return {from.x + a * cx + b * motion.x, from.y + a * cy + b * motion.y, std::atan2(sign * dy, sign * dx)};
}

/// True when the robot's rectangle touches a cell's inside: separating axes, in double.
inline bool outline_touches(const GroundPathConfig& config, const OutlinePose& pose, std::int32_t x,
                            std::int32_t y) {
  const double l = static_cast<double>(config.half_length_mm) / config.cell_mm;
  const double w = static_cast<double>(config.half_width_mm) / config.cell_mm;
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  const double dx = x - pose.x;
  const double dy = y - pose.y;
  const double own = 0.5 * (std::abs(c) + std::abs(s)) - 1e-9;
  return std::abs(dx * c + dy * s) < l + own && std::abs(dy * c - dx * s) < w + own &&
         std::abs(dx) < 0.5 - 1e-9 + l * std::abs(c) + w * std::abs(s) &&
         std::abs(dy) < 0.5 - 1e-9 + l * std::abs(s) + w * std::abs(c);
}

/// Cells of ground that was not seen to carry, near the robot's height, under its outline on a part of a way.
inline int bad_ground(const OwnedGround& g, std::span<const GroundStep> way) {
  int bad = 0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const GroundPose& from = way[i - 1].pose;
    const Motion& motion = g.path.motions().motion(from.heading, way[i].motion);
    const GroundCell& here = g.map.cell(from.x, from.y);
    for (int k = 0; k <= 40; ++k) {
      const OutlinePose pose = outline_at(from, motion, k / 40.0);
      const auto mx = static_cast<std::int32_t>(std::lround(pose.x));
      const auto my = static_cast<std::int32_t>(std::lround(pose.y));
      for (std::int32_t y = my - 20; y <= my + 20; ++y) {
        for (std::int32_t x = mx - 20; x <= mx + 20; ++x) {
          if (!outline_touches(g.config, pose, x, y)) continue;
          bool carries = false;
          for (const int s : {0, 1})
            carries =
                carries || (g.map.is_inside(x, y) && g.map.cell(x, y).state[s] == GroundState::carries &&
                            std::abs(g.map.cell(x, y).height_mm[s] - here.height_mm[from.surface]) <=
                                2 * g.config.reach_mm);
          if (!carries) ++bad;
        }
      }
    }
  }
  return bad;
}

}  // namespace sortie::planner::test
