// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/local_segments.hpp"

#include <algorithm>

namespace sortie::mapping {

LocalSegments::LocalSegments(const SegmentWatchConfig& config, std::uint32_t most_segments,
                             std::uint32_t chosen, rt::Arena& arena)
    : describer_(most_segments, chosen, arena),
      watch_(config, arena),
      most_chosen_(chosen),
      events_(arena.make_array<SegmentEvent>("recognition events", kMostEvents)),
      chosen_(arena.make_array<std::uint16_t>("recognition wanted", most_segments)) {}

void LocalSegments::note(const Labelling& labelling) {
  const std::uint64_t finished = labelling.counts().labellings;
  if (finished == labellings_) return;
  events_lost_ += finished > labellings_ ? finished - labellings_ - 1 : 0;
  labellings_ = finished;
  for (const SegmentEvent& event : labelling.events()) {
    if (event_count_ == events_.size()) {
      ++events_lost_;
    } else {
      events_[event_count_++] = event;
    }
  }
}

/// Slots of those that want a description, as many as there is room for.
void LocalSegments::choose(const Labelling& labelling) {
  const auto slots = labelling.slots();
  chosen_count_ = 0;
  for (std::uint32_t s = 0; s < slots.size() && chosen_count_ < chosen_.size(); ++s) {
    if (slots[s].voxels[labelling.shown()] == 0) continue;
    const WatchedSegment* const segment = watch_.find(slots[s].id);
    if (segment != nullptr && segment->wanted) chosen_[chosen_count_++] = static_cast<std::uint16_t>(s);
  }
  if (chosen_count_ <= most_chosen_) return;
  std::sort(chosen_.begin(), chosen_.begin() + chosen_count_, [&](std::uint16_t a, std::uint16_t b) {
    const WatchedSegment &x = *watch_.find(slots[a].id), &y = *watch_.find(slots[b].id);
    return x.rest_since_ns != y.rest_since_ns ? x.rest_since_ns < y.rest_since_ns : x.id < y.id;
  });
  chosen_count_ = most_chosen_;
}

Status LocalSegments::round(const RollingGrid& grid, const FragmentGraph& graph, const Labelling& labelling,
                            rt::Nanoseconds now_ns, std::uint32_t& units) {
  constexpr std::uint32_t kAll = ~0u;
  units = 0;
  if (const Status status = describer_.begin(grid, labelling); status != Status::ok) return status;
  if (const Status status = watch_.begin(now_ns); status != Status::ok) return status;
  units += describer_.run(grid, graph, labelling, kAll);
  watch_.note(events_.first(event_count_));
  event_count_ = 0;
  const auto slots = labelling.slots();
  for (std::uint32_t s = 0; s < slots.size(); ++s) {
    const auto slot = static_cast<std::uint16_t>(s);
    // Not the labelling's number: voxels may have left since, and the place is that of the rest.
    const auto voxels = static_cast<std::uint32_t>(describer_.moments(slot).count);
    if (slots[s].id == kNoSegment || voxels == 0) continue;
    watch_.see({slots[s].id, voxels, describer_.place(slot), describer_.is_inside(slot)});
  }
  watch_.end();
  choose(labelling);
  if (chosen_count_ == 0 || describer_.choose(chosen_.first(chosen_count_)) != Status::ok) return Status::ok;
  units += describer_.run(grid, graph, labelling, kAll);
  for (const DescribedSegment& segment : describer_.described()) {
    if (segment.sound) (void)watch_.describe(segment.id, segment.descriptor);
  }
  return Status::ok;
}

void LocalSegments::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "local segments")
      .fixed(most_chosen_)
      .scratch(chosen_, chosen_count_)
      .by_hand(events_)
      .state(describer_, watch_, event_count_, labellings_, events_lost_);
  if (archive.is_reading() && event_count_ > events_.size()) {
    archive.fail(Status::malformed, "more events than there is room for");
    event_count_ = 0;
  }
  for (SegmentEvent& event : events_.first(event_count_)) archive.value(event);
}

}  // namespace sortie::mapping
