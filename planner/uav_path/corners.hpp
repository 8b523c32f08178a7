// SPDX-License-Identifier: BSD-3-Clause
// A way as a list of voxels, and how it becomes short: the shortest chain of straight lines between its
// points, again and again with new points on the lines.
#pragma once

#include <cstdint>
#include <span>

#include "planner/uav_path/coarse_search.hpp"
#include "planner/uav_path/fine_search.hpp"

namespace sortie::planner {

/// Memory of a way, which outlives it: three arrays of one length, at least kFewest.
struct CornerMemory {
  static constexpr std::uint32_t kFewest = 256;
  std::span<Voxel3> points;
  std::span<float> lengths;
  std::span<std::uint32_t> before;
};

/// A way from start to goal. Between begin_*() and the first full round it bends at every voxel; each
/// finished round leaves it as short or shorter. Neighbours always see each other (line_is_free). No heap,
/// deterministic.
class Corners {
 public:
  explicit Corners(const CornerMemory& memory) : memory_(memory) {}

  /// The way that a fine search found. `full`: it bends more often than there is room.
  Status take(const FineSearch& fine);

  /// A way without any search: from part to part as the coarse search leads, by breadth first within each
  /// brick. Longer, but it needs no memory of its own. Status as for take().
  Status crawl(const FlightMap& map, const CoarseSearch& coarse, const Voxel3& start, const Voxel3& goal);

  /// Goes on shortening for about `units` voxels of lines of sight; takes what it used off, and past zero by
  /// the lines of one point, or of all new points of a round (256 pieces of the way), at the most. True when
  /// nothing gets shorter any more, or after kMostRounds.
  bool shorten(const FlightMap& map, std::uint64_t& units);

  /// The way: after a finished round its corners alone. Never shorter than 1; the first is the start.
  std::span<const Voxel3> points() const { return memory_.points.first(count_); }
  /// Rounds that were finished.
  std::uint32_t rounds() const { return rounds_; }
  /// Length in voxels.
  float length() const;

 private:
  static constexpr std::uint32_t kMostRounds = 6;
  static constexpr std::uint32_t kResampled = 192;  // points of a later round
  bool append(const Voxel3& v);
  void begin();
  void connect(const FlightMap& map, std::uint32_t i, std::uint64_t& units);
  void keep_chain();
  void resample(const FlightMap& map, std::uint64_t& units);

  CornerMemory memory_;
  std::uint32_t count_{};
  std::uint32_t source_{};
  std::uint32_t rounds_{};
  float last_length_{};
  bool sampled_{};
};

}  // namespace sortie::planner
