// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/fine_search.hpp"

#include <algorithm>
#include <bit>

namespace sortie::planner {
namespace {

constexpr float kStep[4] = {0.0f, 1.0f, 1.41421356f, 1.73205081f};  // by how many coordinates change
// How many parts nearer to the goal a voxel looks. With one the estimate bends at each brick, with three it
// sees through corners.
constexpr int kAhead = 2;
// The estimate counts for more than the way so far: the search runs straight along what the wide one found
// (some hundred voxels instead of some ten thousand), and shortening makes up for what that costs in length.
constexpr float kGreed = 1.2f;

constexpr std::uint32_t pack(const Voxel3& v) {
  return 1u + (static_cast<std::uint32_t>(v.x) | static_cast<std::uint32_t>(v.y) << 10 |
               static_cast<std::uint32_t>(v.z) << 20);
}

}  // namespace

FineSearch::FineSearch(const FineMemory& memory)
    : table_(memory.table.first(std::bit_floor(std::min(memory.table.size(), memory.heap.size())))),
      target_points_(memory.target_points),
      target_lengths_(memory.target_lengths),
      heap_(memory.heap) {}

void FineSearch::begin(const FlightMap& map, const CoarseSearch& coarse, const Voxel3& start,
                       const Voxel3& goal) {
  std::fill(table_.begin(), table_.end(), FineVoxel{});
  std::fill(target_lengths_.begin(), target_lengths_.end(), -1.0f);
  count_ = 0;
  heap_.clear();
  goal_ = goal;
  goal_slot_ = kNoNode;
  state_ = SearchState::capacity;
  if (table_.empty() || target_points_.size() < coarse.size() || target_lengths_.size() < coarse.size())
    return;
  state_ = SearchState::running;
  if (!reach(map, coarse, start, 0.0f, kNoNode)) state_ = SearchState::none;
}

SearchState FineSearch::run(const FlightMap& map, const CoarseSearch& coarse, std::uint64_t& units) {
  while (state_ == SearchState::running && units > 0) {
    --units;
    if (heap_.empty()) {
      state_ = SearchState::none;
      break;
    }
    if (4 * std::uint64_t{count_ + 26} > 3 * std::uint64_t{table_.size()}) {
      state_ = SearchState::capacity;
      break;
    }
    const std::uint32_t slot = heap_.pop(*this);
    table_[slot].place = kSettled;
    const Voxel3 v = voxel(slot);
    if (v == goal_) {
      goal_slot_ = slot;
      state_ = SearchState::found;
      break;
    }
    const float so_far = table_[slot].from_start;
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Voxel3 near{v.x + dx, v.y + dy, v.z + dz};
          const int changes = dx * dx + dy * dy + dz * dz;
          if (changes > 0 && map.is_free(near))
            static_cast<void>(reach(map, coarse, near, so_far + kStep[changes], slot));
        }
      }
    }
  }
  return state_;
}

Voxel3 FineSearch::voxel(std::uint32_t slot) const {
  const std::uint32_t packed = table_[slot].key - 1u;
  return {static_cast<std::int32_t>(packed & 1023u), static_cast<std::int32_t>(packed >> 10 & 1023u),
          static_cast<std::int32_t>(packed >> 20)};
}

// Where a voxel is, or belongs. Never full: see run().
std::uint32_t FineSearch::slot_of(const Voxel3& v) const {
  const std::uint32_t key = pack(v);
  const auto mask = static_cast<std::uint32_t>(table_.size() - 1);
  std::uint32_t slot = (key * 0x9e3779b1u ^ key >> 15) & mask;
  while (table_[slot].key != 0 && table_[slot].key != key) slot = (slot + 1) & mask;
  return slot;
}

// False where the goal's distance is not known.
bool FineSearch::reach(const FlightMap& map, const CoarseSearch& coarse, const Voxel3& v, float from_start,
                       std::uint32_t parent) {
  const std::uint32_t slot = slot_of(v);
  FineVoxel& entry = table_[slot];
  if (entry.key == 0) {
    const std::uint32_t node = coarse.node_of(map, v);
    if (node == kNoNode || !coarse.is_settled(node)) return false;
    entry = {pack(v), from_start, from_start + kGreed * length_to_goal(coarse, node, v),
             parent == kNoNode ? slot : parent, 0};
    ++count_;
    heap_.push(slot, *this);
  } else if (entry.place != kSettled && from_start < entry.from_start) {
    entry.estimate -= entry.from_start - from_start;
    entry.from_start = from_start;
    entry.parent = parent;
    heap_.move_up(entry.place, *this);
  }
  return true;
}

float FineSearch::length_to_goal(const CoarseSearch& coarse, std::uint32_t node, const Voxel3& v) {
  if (target_lengths_[node] < 0.0f) {
    std::uint32_t ahead = node;
    for (int i = 0; i < kAhead && coarse.node(ahead).next != kNoNode; ++i) ahead = coarse.node(ahead).next;
    const bool is_last = coarse.node(ahead).next == kNoNode;
    target_points_[node] = is_last ? to_point(goal_) : coarse.node(ahead).middle;
    target_lengths_[node] = coarse.node(ahead).to_goal;
  }
  return target_lengths_[node] + distance(target_points_[node], to_point(v));
}

}  // namespace sortie::planner
