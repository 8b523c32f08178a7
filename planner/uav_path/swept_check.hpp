// SPDX-License-Identifier: BSD-3-Clause
// The last word on a piece of way: the robot's ellipsoid, swept along the line, against every blocked voxel
// near it.
#pragma once

#include <cstdint>
#include <span>

#include "planner/uav_path/flight_map.hpp"
#include "rt/archive.hpp"

namespace sortie::planner {

/// What a check said.
struct SweptCheck {
  bool is_free{};           ///< a gap was proved to every blocked voxel and to the map's border
  std::uint32_t queries{};  ///< pairs that were judged
  std::uint32_t bricks{};   ///< that were looked at: those along the line, whatever the map's size
  SORTIE_FIELDS(is_free, queries, bricks)
};

/// Judges the straight way from `a_m` to `b_m` (world), in slices. Exact to 1e-9 m, on the safe side: what
/// cannot be decided within the bounds of rt/convex counts as a collision, so does anything outside of the
/// map. The map stands still meanwhile. Steps are sixteenths of a work unit: one for a row of bricks or a
/// brick along the line, kCloser for one with something in it near the line, kPair for a pair that is judged
/// (150 ns). No heap.
class SweptWalk {
 public:
  static constexpr std::uint64_t kCloser = 16;
  static constexpr std::uint64_t kPair = 16;
  /// A brick is not cut in two, so that much more is used at the most.
  static constexpr std::uint64_t kMostPastEnd = 1 + kCloser + 64 * kPair;

  /// Another line; nothing is looked at yet. `share` of the map's radii: less than 1 for a robot that stands
  /// nearer to something than it would go.
  void begin(const rt::Vector3& a_m, const rt::Vector3& b_m, double share = 1.0);
  /// Goes on for about `steps`, and takes off what it used, 0 at the least. True when the line is judged.
  bool run(const FlightMap& map, std::uint64_t& steps);
  /// After run() said true. Before that is_free is false, and the counts rise.
  const SweptCheck& result() const { return result_; }

  /// State to bytes and back.
  void archive(rt::Archive& archive);

 private:
  bool ended(bool is_free) {
    result_.is_free = is_free;
    return true;
  }

  rt::Vector3 a_m_;
  rt::Vector3 b_m_;
  double share_{1.0};
  std::int32_t next_[3]{};  ///< brick to look at next: x, y, z
  SweptCheck result_;
};

/// Judges the lines between the points of a way, one after the other, in slices. The points and the map stand
/// still meanwhile.
class WayWalk {
 public:
  /// Another way; `share` as in SweptWalk::begin().
  void begin(double share = 1.0) {
    *this = {};
    share_ = share;
  }
  /// As SweptWalk::run(), for all of the way. Stops at the first line that is not free.
  bool run(const FlightMap& map, std::span<const rt::Vector3> way_m, std::uint64_t& steps);
  bool is_free() const { return is_free_; }
  /// State to bytes and back.
  void archive(rt::Archive& archive);

 private:
  SweptWalk walk_;
  double share_{1.0};
  std::uint32_t line_{};  ///< being judged
  bool begun_{};
  bool is_free_{};
};

}  // namespace sortie::planner
