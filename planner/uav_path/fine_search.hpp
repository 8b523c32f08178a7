// SPDX-License-Identifier: BSD-3-Clause
// The second look: a way from voxel to voxel, led by what the first one knows of the distance to the goal.
#pragma once

#include <cstdint>
#include <span>

#include "planner/uav_path/coarse_search.hpp"

namespace sortie::planner {

/// A voxel that was met. 24 bytes.
struct FineVoxel {
  std::uint32_t key{};  ///< packed voxel + 1; 0: empty
  float from_start{};
  float estimate{};
  std::uint32_t parent{};  ///< slot of the voxel before
  std::uint32_t place{};   ///< in the heap, or settled
};

/// Memory of the search, which outlives it. `table` is a power of two; a quarter of it stays empty.
struct FineMemory {
  std::span<FineVoxel> table;
  std::span<std::uint32_t> heap;        ///< as many as table
  std::span<VoxelPoint> target_points;  ///< as many as the coarse search's nodes
  std::span<float> target_lengths;      ///< the same
};

/// A* over free voxels and their 26 neighbours, among parts whose way to the goal is known. The estimate of a
/// voxel is the straight line to the part two steps nearer to the goal, and the way from there: good enough
/// that a search settles little more than the voxels of the way itself. No heap memory, deterministic.
class FineSearch {
 public:
  explicit FineSearch(const FineMemory& memory);

  /// Starts anew. `coarse` must have found a way between the same voxels.
  void begin(const FlightMap& map, const CoarseSearch& coarse, const Voxel3& start, const Voxel3& goal);

  /// Goes on for at most `units` voxels; takes what it used off. `none` cannot be: where the coarse search
  /// found a way there is one. `capacity` when the table is full.
  SearchState run(const FlightMap& map, const CoarseSearch& coarse, std::uint64_t& units);

  /// After `found`: the way from goal to start, as one voxel a call: first(), then before(). kNoNode behind
  /// the start.
  std::uint32_t first() const { return goal_slot_; }
  std::uint32_t before(std::uint32_t slot) const {
    return table_[slot].parent == slot ? kNoNode : table_[slot].parent;
  }
  Voxel3 voxel(std::uint32_t slot) const;

  bool comes_before(std::uint32_t a, std::uint32_t b) const {
    const FineVoxel& p = table_[a];
    const FineVoxel& q = table_[b];
    if (p.estimate != q.estimate) return p.estimate < q.estimate;
    return p.from_start != q.from_start ? p.from_start > q.from_start : p.key < q.key;
  }
  void set_place(std::uint32_t slot, std::uint32_t place) { table_[slot].place = place; }

 private:
  static constexpr std::uint32_t kSettled = UINT32_MAX - 1;
  std::uint32_t slot_of(const Voxel3& v) const;
  bool reach(const FlightMap& map, const CoarseSearch& coarse, const Voxel3& v, float from_start,
             std::uint32_t parent);
  float length_to_goal(const CoarseSearch& coarse, std::uint32_t node, const Voxel3& v);

  std::span<FineVoxel> table_;
  std::span<VoxelPoint> target_points_;
  std::span<float> target_lengths_;
  OrderedHeap heap_;
  std::uint32_t count_{};
  std::uint32_t goal_slot_{kNoNode};
  Voxel3 goal_;
  SearchState state_{SearchState::none};
};

}  // namespace sortie::planner
