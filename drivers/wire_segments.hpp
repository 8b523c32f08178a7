// SPDX-License-Identifier: BSD-3-Clause
// segments_t: the segments of a local map and their events. The encoder is that of wire_fields.hpp; no heap.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "drivers/channels.hpp"
#include "drivers/wire_fields.hpp"
#include "rt/segment_list.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

inline constexpr auto kSegmentSizes = [](auto& segment, auto&& visit) {
  visit("id", segment.id);
  visit("voxels", segment.voxels);
};
inline constexpr auto kSegmentFeatures = [](auto& segment, auto&& visit) {
  visit("centroid", segment.centroid_m);
  visit("least", segment.least_m);
  visit("most", segment.most_m);
  visit("feature", segment.feature);
};
template <>
struct WireRules<rt::SegmentEvent> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("change", self.change);
    visit("event_id", self.id);
    visit("event_other", self.other);
  }
};
template <>
struct WireRules<rt::SegmentList> : WireNumbered {
  static constexpr void members(auto& self, auto&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("segments", self.segments);
    visit("events", self.events);
    visit("origin", self.origin_m);
    const std::span segments(self.segment);
    visit("n", self.listed);
    visit("sizes", counted("n", segments, self.listed, Status::full, kSegmentSizes));
    std::uint32_t featured = self.features ? self.listed : 0;
    visit("f", featured);
    const std::uint32_t all = featured == self.listed ? std::min(featured, rt::SegmentList::kMost) : 0;
    visit("features", counted("f", segments.first(all), featured, Status::malformed, kSegmentFeatures));
    if constexpr (requires { self.features = true; }) self.features = featured > 0;
    visit("m", self.listed_events);
    visit("happened", counted("m", std::span(self.event), self.listed_events));
  }
  static bool taken(const rt::SegmentList& list) {
    return std::all_of(list.event, list.event + list.listed_events,
                       [](const rt::SegmentEvent& event) { return event.change <= rt::SegmentChange::gone; });
  }
};

/// Bytes of a message with `segments` segments, of which `featured` have features, and `events` events.
constexpr std::size_t segments_bytes(std::size_t segments, std::size_t featured, std::size_t events) {
  return kLeastBytes<rt::SegmentList> + segments * 8 + featured * 64 + events * 9;
}
inline constexpr std::size_t kMaxSegmentsBytes =
    segments_bytes(rt::SegmentList::kMost, rt::SegmentList::kMost, rt::SegmentList::kMostEvents);
static_assert(kMaxSegmentsBytes < 16'384);

/// In place: `list` is of no use unless ok. More segments than fit are `full`, whatever follows.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::SegmentList& list,
                            std::int64_t& seq) noexcept;

}  // namespace sortie::drivers
