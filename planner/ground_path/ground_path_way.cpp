// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/ground_path.hpp"

#include <algorithm>

namespace sortie::planner {

// Copies the way to a node. Poses on it may have become cheaper since: it costs what its motions cost.
void GroundPath::show(const GroundMap& map, std::uint32_t last) {
  std::size_t steps = 1;
  std::uint32_t total = 0;
  for (std::uint32_t n = last; columns_[n].parent != kNoPlace; n = columns_[n].parent, ++steps) {
    const GroundPose from = pose_of(map, columns_[n].parent);
    total += attempt(map, from, motions_.motion(from.heading, columns_[n].motion)).cost;
  }
  work_.units += 2 * steps;  // each motion is looked at twice
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
