// SPDX-License-Identifier: BSD-3-Clause
// The segments of a local map as they may be recognised: watched, and described when they may speak.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/segment_describer.hpp"
#include "mapping/recognition/segment_watch.hpp"

namespace sortie::mapping {

/// Rounds of describer and watch over one segmenter. note() after each labelling that was finished; a round()
/// now and then. A round visits each voxel of the segments once, and those of segments that want a
/// description once more; at most `chosen` of these a round, those that are longest at rest first. No heap.
class LocalSegments {
 public:
  static constexpr std::uint32_t kMostEvents = 2048;  ///< between two rounds

  /// `most_segments`: of the labelling; `chosen`: descriptions a round.
  LocalSegments(const SegmentWatchConfig& config, std::uint32_t most_segments, std::uint32_t chosen,
                rt::Arena& arena);

  /// The events of a labelling, if it is another one than at the call before.
  void note(const Labelling& labelling);
  /// Watches and describes what is shown now. Status as of SegmentWatch::begin() and
  /// SegmentDescriber::begin(); then no segment has changed. Gives the voxels that were visited in `units`.
  [[nodiscard]] Status round(const RollingGrid& grid, const FragmentGraph& graph, const Labelling& labelling,
                             rt::Nanoseconds now_ns, std::uint32_t& units);

  /// Of the newest round, by rising id.
  std::span<const WatchedSegment> segments() const { return watch_.segments(); }
  const SegmentWatchCounts& counts() const { return watch_.counts(); }
  const DescribeCounts& described() const { return describer_.counts(); }
  /// Events for which there was no room, and labellings that no call of note() saw, one each. Segments that
  /// were joined or cut may have gone on speaking until they were described anew.
  std::uint64_t events_lost() const { return events_lost_; }
  void archive(rt::Archive& archive);

 private:
  void choose(const Labelling& labelling);

  SegmentDescriber describer_;
  SegmentWatch watch_;
  std::uint32_t most_chosen_;
  std::span<SegmentEvent> events_;
  std::span<std::uint16_t> chosen_;  ///< slots that want a description
  std::uint32_t event_count_{};
  std::uint32_t chosen_count_{};
  std::uint64_t labellings_{};
  std::uint64_t events_lost_{};
};

}  // namespace sortie::mapping
