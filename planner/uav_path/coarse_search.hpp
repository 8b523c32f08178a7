// SPDX-License-Identifier: BSD-3-Clause
// The first, wide look: how far is the goal from every part of the map on the way? One node is one connected
// part of a brick, so a wall never leaks, however thin: where this search finds no way there is none.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "planner/uav_path/flight_map.hpp"
#include "planner/uav_path/ordered_heap.hpp"

namespace sortie::planner {

inline constexpr std::uint32_t kNoNode = UINT32_MAX;

/// A place in voxels, for distances.
struct VoxelPoint {
  float x{};
  float y{};
  float z{};
};

/// Distance in voxels.
inline float distance(const VoxelPoint& a, const VoxelPoint& b) {
  const float x = a.x - b.x;
  const float y = a.y - b.y;
  const float z = a.z - b.z;
  return std::sqrt(x * x + y * y + z * z);
}
inline VoxelPoint to_point(const Voxel3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// A connected part of a brick's free voxels. 48 bytes.
struct PathNode {
  BrickMask voxels{};
  VoxelPoint middle;  ///< mean of its voxels
  float to_goal{};    ///< length of the way over the middles of parts
  float estimate{};   ///< and on to the start, as the crow flies
  std::uint32_t brick{};
  std::uint32_t sibling{kNoNode};  ///< next part of the same brick
  std::uint32_t next{kNoNode};     ///< towards the goal
  std::uint32_t place{};           ///< in the heap; see CoarseSearch::is_settled
};

/// How a search stands.
enum class SearchState : std::uint8_t {
  running,
  found,
  none,      ///< there is no way
  capacity,  ///< the memory ended before the search
};

/// Memory of a search, which outlives it. A map of n bricks has rarely more than 1.3 n parts; 8 n are always
/// enough.
struct CoarseMemory {
  std::span<PathNode> nodes;
  std::span<std::uint32_t> heap;         ///< as many as nodes
  std::span<std::uint32_t> brick_nodes;  ///< as many as the map has bricks
};

/// A* over the parts of bricks, from the goal back to the start. No heap memory. Deterministic: ties go to
/// the part that was met first.
class CoarseSearch {
 public:
  explicit CoarseSearch(const CoarseMemory& memory);

  /// Starts anew between two free voxels.
  void begin(const FlightMap& map, const Voxel3& start, const Voxel3& goal);

  /// Goes on for at most `units` parts; takes what it used off. The map must not have changed since begin().
  SearchState run(const FlightMap& map, std::uint64_t& units);

  /// The part that holds a free voxel, if it was met; else kNoNode.
  std::uint32_t node_of(const FlightMap& map, const Voxel3& v) const;
  /// True when the way from there to the goal is known.
  bool is_settled(std::uint32_t node) const { return nodes_[node].place == kSettled; }
  const PathNode& node(std::uint32_t index) const { return nodes_[index]; }
  /// Parts met so far.
  std::uint32_t size() const { return count_; }

  // For the heap.
  bool comes_before(std::uint32_t a, std::uint32_t b) const {
    return nodes_[a].estimate != nodes_[b].estimate ? nodes_[a].estimate < nodes_[b].estimate : a < b;
  }
  void set_place(std::uint32_t node, std::uint32_t place) { nodes_[node].place = place; }

 private:
  static constexpr std::uint32_t kUnseen = UINT32_MAX - 1;   // brick_nodes_: its parts were not made yet
  static constexpr std::uint32_t kSettled = UINT32_MAX - 2;  // PathNode::place
  bool make_parts(const FlightMap& map, std::uint32_t brick);
  bool expand(const FlightMap& map, std::uint32_t index);
  void reach(std::uint32_t from, std::uint32_t to);

  std::span<PathNode> nodes_;
  std::span<std::uint32_t> brick_nodes_;
  OrderedHeap heap_;
  std::uint32_t count_{};
  std::uint32_t start_{kNoNode};
  VoxelPoint start_point_;
  SearchState state_{SearchState::none};
};

}  // namespace sortie::planner
