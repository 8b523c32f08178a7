// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/coarse_search.hpp"

#include <algorithm>

namespace sortie::planner {

CoarseSearch::CoarseSearch(const CoarseMemory& memory)
    : nodes_(memory.nodes.first(std::min(memory.nodes.size(), memory.heap.size()))),
      brick_nodes_(memory.brick_nodes),
      heap_(memory.heap) {}

void CoarseSearch::begin(const FlightMap& map, const Voxel3& start, const Voxel3& goal) {
  count_ = 0;
  heap_.clear();
  start_ = kNoNode;
  state_ = SearchState::capacity;
  if (brick_nodes_.size() != map.free_bricks().size()) return;
  std::fill(brick_nodes_.begin(), brick_nodes_.end(), kUnseen);
  if (!make_parts(map, map.brick_of(goal)) || !make_parts(map, map.brick_of(start))) return;
  start_ = node_of(map, start);
  start_point_ = to_point(start);
  const std::uint32_t first = node_of(map, goal);
  state_ = first == kNoNode || start_ == kNoNode ? SearchState::none : SearchState::running;
  if (state_ != SearchState::running) return;
  nodes_[first].to_goal = 0.0f;
  nodes_[first].estimate = distance(nodes_[first].middle, start_point_);
  heap_.push(first, *this);
}

SearchState CoarseSearch::run(const FlightMap& map, std::uint64_t& units) {
  while (state_ == SearchState::running && units > 0) {
    --units;
    if (heap_.empty()) {
      state_ = SearchState::none;
      break;
    }
    const std::uint32_t index = heap_.pop(*this);
    nodes_[index].place = kSettled;
    if (index == start_) {
      state_ = SearchState::found;
    } else if (!expand(map, index)) {
      state_ = SearchState::capacity;
    }
  }
  return state_;
}

std::uint32_t CoarseSearch::node_of(const FlightMap& map, const Voxel3& v) const {
  if (!map.is_inside(v)) return kNoNode;
  std::uint32_t n = brick_nodes_[map.brick_of(v)];
  if (n == kUnseen) return kNoNode;
  while (n != kNoNode && (nodes_[n].voxels & brick_bit(v)) == 0) n = nodes_[n].sibling;
  return n;
}

// Splits a brick into its parts. False when the memory ends.
bool CoarseSearch::make_parts(const FlightMap& map, std::uint32_t brick) {
  if (brick_nodes_[brick] != kUnseen) return true;
  brick_nodes_[brick] = kNoNode;
  BrickMask left = map.free_bricks()[brick];
  const VoxelPoint corner = to_point(map.corner_of(brick));
  while (left != 0) {
    if (count_ == nodes_.size()) return false;
    PathNode& node = nodes_[count_];
    node = {};
    node.voxels = left == kWholeBrick ? left : brick_part(lowest_voxel(left), left);
    left &= ~node.voxels;
    const BrickSums sums = brick_sums(node.voxels);
    const float share = 1.0f / static_cast<float>(sums.count);
    node.middle = {corner.x + share * static_cast<float>(sums.x),
                   corner.y + share * static_cast<float>(sums.y),
                   corner.z + share * static_cast<float>(sums.z)};
    node.brick = brick;
    node.place = OrderedHeap::kNowhere;
    node.sibling = brick_nodes_[brick];
    brick_nodes_[brick] = count_++;
  }
  return true;
}

bool CoarseSearch::expand(const FlightMap& map, std::uint32_t index) {
  const BrickMask voxels = nodes_[index].voxels;
  const Voxel3 corner = map.corner_of(nodes_[index].brick);
  for (int dz = -1; dz <= 1; ++dz) {
    const BrickMask reach_z = detail::reach_z(voxels, dz);
    if (reach_z == 0) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      const BrickMask reach_y = detail::reach_y(reach_z, dy);
      if (reach_y == 0) continue;
      for (int dx = -1; dx <= 1; ++dx) {
        const Voxel3 beside{corner.x + 4 * dx, corner.y + 4 * dy, corner.z + 4 * dz};
        if (!map.is_inside(beside) || beside == corner) continue;
        const std::uint32_t near = map.brick_of(beside);
        const BrickMask touched = detail::reach_x(reach_y, dx) & map.free_bricks()[near];
        if (touched == 0) continue;
        if (!make_parts(map, near)) return false;
        for (std::uint32_t n = brick_nodes_[near]; n != kNoNode; n = nodes_[n].sibling) {
          if ((nodes_[n].voxels & touched) != 0) reach(index, n);
        }
      }
    }
  }
  return true;
}

void CoarseSearch::reach(std::uint32_t from, std::uint32_t to) {
  PathNode& node = nodes_[to];
  if (node.place == kSettled) return;
  const float length = nodes_[from].to_goal + distance(nodes_[from].middle, node.middle);
  const bool is_new = node.place == OrderedHeap::kNowhere;
  if (!is_new && !(length < node.to_goal)) return;
  node.to_goal = length;
  node.estimate = length + distance(node.middle, start_point_);
  node.next = from;
  if (is_new)
    heap_.push(to, *this);
  else
    heap_.move_up(node.place, *this);
}

}  // namespace sortie::planner
