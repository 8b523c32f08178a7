// SPDX-License-Identifier: BSD-3-Clause
// Visits the voxels of a map's segments twice, in slices: first all for their sums, then those of some chosen
// segments for their descriptors.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/rolling_grid.hpp"
#include "mapping/recognition/place_cm.hpp"
#include "mapping/recognition/segment_shape.hpp"
#include "mapping/segments/labelling.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/describe.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// How far a describer is.
enum class DescribeStage : std::uint8_t {
  idle,       ///< nothing begun, or what was begun was dropped
  summing,    ///< first visit
  summed,     ///< sums of all segments can be read, segments can be chosen
  framing,    ///< middle and axes of the chosen ones
  counting,   ///< second visit
  described,  ///< descriptors can be read; others can be chosen
};

/// Counters since start.
struct DescribeCounts {
  std::uint64_t begun{};
  std::uint64_t dropped{};    ///< another labelling was shown before they were done, or begin() amid a visit
  std::uint64_t described{};  ///< segments
  std::uint64_t disturbed{};  ///< segments whose voxels were not as many in the second visit as in the first
  SORTIE_FIELDS(begun, dropped, described, disturbed)
};

/// A segment that was described.
struct DescribedSegment {
  SegmentId id{};
  std::uint16_t slot{};  ///< of the labelling
  bool sound{};          ///< false: disturbed; there is no descriptor
  std::uint32_t voxels{};
  PlaceCm place;  ///< mean of its voxels in the grid's frame
  SegmentDescriptor descriptor;
};

/// Describes segments of one labelling: begin(), run() until summed, choose(), run() until described; then
/// choose() again, or begin(). All of it holds for the labelling that was shown at begin(): when another one
/// is shown, run() drops everything and counts it. Scans that come between two slices may move means and take
/// blocks away: what is summed up stays safe and the same in every run, but a segment that lost or won a
/// voxel between the visits is not described. Give it enough units, and no scan comes between.
///
/// A unit is a voxel, or a fragment that is passed over; a frame takes kFrameUnits. Measured: 8 ns a unit of
/// the first visit and 14 ns of the second. Memory: 107 bytes a segment of the map, and 280 bytes a chosen
/// one. No heap.
class SegmentDescriber {
 public:
  static constexpr std::uint32_t kFrameUnits = 64;

  /// `segments`: most slots of the labelling; `chosen`: most segments at a time.
  SegmentDescriber(std::uint32_t segments, std::uint32_t chosen, rt::Arena& arena);

  /// Begins with what `labelling` shows. out_of_range, and nothing begun: it has more slots than there is
  /// memory for.
  Status begin(const RollingGrid& grid, const Labelling& labelling);
  /// Goes on until a stage is reached where the caller is asked, or `units` are used: at most one fragment
  /// beyond. Gives what was used. The grid and the graph of the labelling.
  std::uint32_t run(const RollingGrid& grid, const FragmentGraph& graph, const Labelling& labelling,
                    std::uint32_t units);
  /// Chooses slots to describe, once summed. empty: not summed; full: more than there is memory for;
  /// out_of_range: no such slot, or one twice. Then nothing is changed.
  Status choose(std::span<const std::uint16_t> slots);

  DescribeStage stage() const { return stage_; }
  /// Once summed, of a slot below slots(): its sums, relative to the corner of block anchor().
  const SegmentMoments& moments(std::uint16_t slot) const { return moments_[slot]; }
  const BlockAt& anchor() const { return anchor_; }
  std::uint32_t slots() const { return slots_; }
  /// Once summed: whether all of its blocks lie so far inside the local map that it cannot go on outside.
  bool is_inside(std::uint16_t slot) const { return outside_[slot] == 0; }
  /// Once summed: mean of its voxels in the grid's frame; the same wherever the anchor is.
  PlaceCm place(std::uint16_t slot) const;
  /// Once described, in the order in which they were chosen.
  std::span<const DescribedSegment> described() const {
    return described_.first(stage_ == DescribeStage::described ? chosen_ : 0);
  }
  const DescribeCounts& counts() const { return counts_; }

  /// Counters to bytes and back. What was begun is not kept, and begins anew.
  void archive(rt::Archive& archive);

 private:
  static constexpr std::uint16_t kNone = 0xffff;
  static constexpr std::int32_t kReach = 511;  ///< blocks from the anchor: coordinates stay below 2^19

  void drop();
  void visit(const RollingGrid& grid, const FragmentNode& node, std::uint16_t slot);
  void finish();
  bool lies_outside(const BlockAt& at) const;

  std::span<SegmentMoments> moments_;      ///< one a slot
  std::span<std::uint8_t> outside_;        ///< one a slot: 1, a block of it may be cut off
  std::span<std::uint16_t> chosen_of_;     ///< one a slot: its number among the chosen
  std::span<SegmentFrame> frames_;         ///< one a chosen segment
  std::span<SegmentShape> shapes_;         ///< one a chosen segment
  std::span<DescribedSegment> described_;  ///< one a chosen segment
  DescribeStage stage_{DescribeStage::idle};
  std::uint32_t at_{};  ///< node or chosen segment that is next
  std::uint32_t slots_{};
  std::uint32_t chosen_{};
  std::uint64_t labelling_{};  ///< number of the one that is described
  double voxel_size_m_{};
  BlockAt anchor_;
  std::int64_t
      inside2_{};  ///< square of the blocks from the anchor's within which none is cut off; < 0: none
  std::int32_t inside_z_{};  ///< the same, upwards and downwards
  DescribeCounts counts_;
};

}  // namespace sortie::mapping
