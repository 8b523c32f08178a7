// SPDX-License-Identifier: BSD-3-Clause
// A short, safe way through the map for a flying robot: wide search, fine search, shortening, exact check; in
// slices of work, with an answer at any time after the first way was found.
#pragma once

#include <cstdint>
#include <span>

#include "planner/uav_path/coarse_search.hpp"
#include "planner/uav_path/corners.hpp"
#include "planner/uav_path/fine_search.hpp"
#include "planner/uav_path/flight_map.hpp"
#include "planner/uav_path/swept_check.hpp"

namespace sortie::planner {

/// Where a plan stands.
enum class PathState : std::uint8_t {
  idle,       ///< nothing was asked
  running,    ///< no way yet
  found,      ///< there is a way; more work may make it shorter
  done,       ///< there is a way, and it gets no shorter
  none,       ///< there is no way
  capacity,   ///< the memory is too small for this map
  bad_start,  ///< no free voxel can be reached from the start: the robot stands too near to something
  bad_goal,   ///< the goal's voxel is not free
  outdated,   ///< the map changed: ask again
};

/// Memory of a planner, which outlives it.
struct UavPathMemory {
  CoarseMemory coarse;
  FineMemory fine;
  CornerMemory corners;
};

/// What was done, for reports.
struct UavPathWork {
  std::uint64_t units{};
  std::uint32_t parts{};    ///< connected parts of bricks that were met
  std::uint32_t crawled{};  ///< plans that were led by the parts alone: no memory for the fine search
  std::uint32_t exact{};    ///< pairs that the exact check judged, all plans
  std::uint32_t bricks{};   ///< that it looked at
  std::uint32_t unsafe{};   ///< ways that the exact check refused: a fault of this program, never shown
};

/// Plans one way at a time. No heap, no clock; the result does not depend on how the work is sliced. Memory
/// as given: 48 bytes a part, 24 a voxel of the fine search, 20 a corner. Source: hierarchical A* as in Holte
/// et al. 1996 with exact connectivity instead of an optimistic one.
class UavPath {
 public:
  static constexpr std::uint32_t kMostWaypoints = 64;
  /// Places that are tried from a start that is not free.
  static constexpr std::uint32_t kMostStarts = 64;
  /// Voxels of a line of sight, or steps of an exact check (SweptWalk), that are one unit.
  static constexpr std::uint64_t kStepsPerUnit = 16;

  explicit UavPath(const UavPathMemory& memory)
      : coarse_(memory.coarse), fine_(memory.fine), corners_(memory.corners) {}

  /// Asks for a way between two points (world). A start in a voxel that is not free is led to a free one
  /// nearby first, in step(). Cost: that of clearing the tables.
  PathState begin(const FlightMap& map, const rt::Vector3& start_m, const rt::Vector3& goal_m);

  /// Works on for at most `units`: a part of a brick, a voxel of the fine search, 16 voxels of a line of
  /// sight, a pair of the exact check and 16 bricks along its line are one each; beyond them by one point's
  /// lines of sight, a round's new points, one brick of the exact check (65 units), or one look around a
  /// start that is not free (22), at the most. Nothing is left out of the units: whoever adds work adds it
  /// there.
  PathState step(const FlightMap& map, std::uint64_t units);

  /// The way as it is now, from start to goal, world; empty before `found`. A way with more corners than room
  /// ends early: then is_whole() is false, and its last point is a good place to ask again from.
  std::span<const rt::Vector3> waypoints() const { return {waypoints_, waypoint_count_}; }
  bool is_whole() const { return whole_; }
  /// Its length, m.
  double length_m() const;

  PathState state() const { return state_; }
  const UavPathWork& work() const { return work_; }

 private:
  enum class Phase : std::uint8_t { lead_in, coarse, fine, judge, shorten };
  // Which of the fresh way's lines is judged.
  enum class Line : std::uint8_t { without_first, without_last, each };
  void lead_in(const FlightMap& map, std::uint64_t& steps);
  void search(const FlightMap& map, std::uint64_t& units);
  void begin_judging(const FlightMap& map);
  void judge(const FlightMap& map, std::uint64_t& steps);
  bool walk_on(const FlightMap& map, std::uint64_t& steps);
  bool next_line();
  void refuse();
  void drop(std::uint32_t point);

  CoarseSearch coarse_;
  FineSearch fine_;
  Corners corners_;
  PathState state_{PathState::idle};
  Phase phase_{Phase::coarse};
  std::uint32_t map_version_{};
  std::uint32_t published_rounds_{};
  rt::Vector3 start_m_;
  rt::Vector3 goal_m_;
  Voxel3 start_;
  Voxel3 goal_;
  rt::Vector3 waypoints_[kMostWaypoints]{};
  std::uint32_t waypoint_count_{};
  bool whole_{};
  bool shortest_{};  ///< the corners get no shorter
  // From a start that is not free: places that were tried; start_ is the last of them.
  std::uint32_t tries_{};
  // The way that is judged before it is shown.
  rt::Vector3 fresh_[kMostWaypoints]{};
  std::uint32_t fresh_count_{};
  bool fresh_whole_{};
  bool walking_{};
  Line line_{};
  std::uint32_t point_{};  ///< at the end of the line that is judged
  SweptWalk walk_;
  UavPathWork work_;
};

}  // namespace sortie::planner
