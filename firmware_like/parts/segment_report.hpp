// SPDX-License-Identifier: BSD-3-Clause
// What a map's segments are and what happened to them, on its way to telemetry.
#pragma once

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/runtime/report_queue.hpp"
#include "mapping/segments/segment_features.hpp"
#include "rt/segment_list.hpp"

namespace sortie::firmware {

/// Gathers the events of every labelling and puts out a list when a scan's labelling is done. In no digest
/// and no part of the state: a replay sends none. Memory: the events of a list, which is made in the queue,
/// and sums of all segments where features are asked for. Cost: O(segments); with features one visit a voxel.
class SegmentReport {
 public:
  SegmentReport(const ChosenMapConfig& config, bool features, ReportQueue<rt::SegmentList>& queue,
                rt::Arena& arena);

  /// After each part of the segmenter's work: the events of a labelling that it finished.
  void note(const ChosenMap& map);
  /// At the end of a job: the list, when there was a labelling since the one before.
  void send(const ChosenMap& map, rt::Nanoseconds stamp_ns);

 private:
  void add_features(const ChosenMap& map, rt::SegmentList& list);

  std::span<mapping::SegmentMoments> moments_;  ///< empty: no features
  ReportQueue<rt::SegmentList>* queue_;
  std::uint32_t events_{};  // since the list before; those that may be listed:
  rt::SegmentEvent event_[rt::SegmentList::kMostEvents];
  std::uint16_t slot_of_[rt::SegmentList::kMost]{};
  std::uint64_t labellings_{};
  bool fresh_{};
};

}  // namespace sortie::firmware
