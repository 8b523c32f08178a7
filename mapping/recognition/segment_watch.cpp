// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/segment_watch.hpp"

#include <algorithm>
#include <utility>

namespace sortie::mapping {
namespace {

bool is_near(const PlaceCm& a, const PlaceCm& b, std::uint32_t within_cm) {
  const std::int64_t x = std::int64_t{a.x} - b.x, y = std::int64_t{a.y} - b.y, z = std::int64_t{a.z} - b.z;
  const std::int64_t most = within_cm;
  // Squares of what is far do not fit.
  if (std::max({x, y, z}) > most || std::min({x, y, z}) < -most) return false;
  return x * x + y * y + z * z < most * most;
}

/// Whether that much time has passed. Stored bytes may say any time that is not to come; the difference has
/// no sign, so that it never overflows.
bool has_passed(rt::Nanoseconds wanted_ns, rt::Nanoseconds since_ns, rt::Nanoseconds now_ns) {
  const auto age_ns = static_cast<std::uint64_t>(now_ns) - static_cast<std::uint64_t>(since_ns);
  return std::cmp_greater_equal(age_ns, wanted_ns);
}

bool by_id(const WatchedSegment& a, const WatchedSegment& b) { return a.id < b.id; }

}  // namespace

SegmentWatch::SegmentWatch(const SegmentWatchConfig& config, rt::Arena& arena)
    : config_(config), segments_(arena.make_array<WatchedSegment>("watched segments", config.watched)) {}

Status SegmentWatch::begin(rt::Nanoseconds now_ns) {
  if (begun_ && now_ns < now_ns_) return Status::time_backwards;
  begun_ = true;
  now_ns_ = now_ns;
  for (WatchedSegment& segment : segments_.first(count_)) segment.seen = segment.wanted = false;
  return Status::ok;
}

WatchedSegment* SegmentWatch::look_up(SegmentId id) {
  const std::span<WatchedSegment> known = segments_.first(sorted_);
  const auto found =
      std::lower_bound(known.begin(), known.end(), id,
                       [](const WatchedSegment& segment, SegmentId wanted) { return segment.id < wanted; });
  return found != known.end() && found->id == id ? &*found : nullptr;
}

const WatchedSegment* SegmentWatch::find(SegmentId id) const {
  return const_cast<SegmentWatch*>(this)->look_up(id);
}

void SegmentWatch::note(std::span<const SegmentEvent> events) {
  // `other` is what was cut, or what took another one in; an id that ends is not seen any more.
  for (const SegmentEvent& event : events) {
    if (event.change != SegmentChange::gone && event.other != kNoSegment) silence(event.other);
  }
}

void SegmentWatch::silence(SegmentId id) {
  WatchedSegment* const segment = look_up(id);
  if (segment == nullptr) return;
  if (segment->speaks) ++counts_.silenced;
  segment->speaks = false;
  segment->rest = segment->now.place;
  segment->rest_since_ns = now_ns_;
}

void SegmentWatch::see(const SegmentSighting& sighting) {
  WatchedSegment* segment = look_up(sighting.id);
  if (segment != nullptr && segment->seen) return;
  if (segment == nullptr) {
    const std::span<const WatchedSegment> fresh = segments_.subspan(sorted_, count_ - sorted_);
    if (std::ranges::find(fresh, sighting.id, &WatchedSegment::id) != fresh.end()) return;
    if (sighting.voxels < config_.min_voxels) {
      ++counts_.small;
      return;
    }
    if (count_ == segments_.size()) {
      ++counts_.refused;
      return;
    }
    segment = &segments_[count_++];
    *segment = {};
    segment->id = sighting.id;
    segment->rest = sighting.place;
    segment->rest_since_ns = now_ns_;
  }
  segment->seen = true;
  segment->now = sighting;
  if (!is_near(sighting.place, segment->rest, config_.drift_cm)) {
    segment->rest = sighting.place;
    segment->rest_since_ns = now_ns_;
  }
  segment->wanted = is_wanted(*segment);
}

bool SegmentWatch::is_wanted(const WatchedSegment& segment) {
  const SegmentSighting& now = segment.now;
  const auto no = [](std::uint64_t& why) {
    ++why;
    return false;
  };
  if (now.voxels < config_.min_voxels) return no(counts_.small);
  if (!now.whole) return no(counts_.cut_off);
  if (!has_passed(config_.rest_ns, segment.rest_since_ns, now_ns_)) return no(counts_.restless);
  if (segment.speaks && now.voxels == segment.described.voxels && now.place == segment.described.place)
    return no(counts_.known);
  if (segment.version > 0 && !has_passed(config_.version_ns, segment.version_at_ns, now_ns_))
    return no(counts_.early);
  return true;
}

void SegmentWatch::end() {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (segments_[i].seen) segments_[kept++] = segments_[i];
  }
  counts_.forgotten += count_ - kept;
  count_ = sorted_ = kept;
  // New ids are greater than all before but for those that grew late: nearly sorted as it is.
  if (!std::is_sorted(segments_.begin(), segments_.begin() + kept, by_id))
    std::sort(segments_.begin(), segments_.begin() + kept, by_id);
}

bool SegmentWatch::describe(SegmentId id, const SegmentDescriptor& descriptor) {
  WatchedSegment* const segment = look_up(id);
  if (segment == nullptr || !segment->wanted) return false;
  segment->wanted = false;
  segment->described = segment->now;
  segment->speaks = true;
  if (segment->version > 0 && segment->place == segment->now.place && segment->descriptor == descriptor) {
    ++counts_.unchanged;
    return false;
  }
  segment->place = segment->now.place;
  segment->descriptor = descriptor;
  segment->version_at_ns = now_ns_;
  ++segment->version;
  ++counts_.versions;
  return true;
}

void SegmentWatch::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "segment watch")
      .state(now_ns_, begun_, counts_)
      .by_hand(segments_, count_, sorted_)
      .fixed(config_);
  archive.bounded(count_, segments_.size());
  for (std::uint32_t i = 0; i < count_; ++i) {
    WatchedSegment& segment = segments_[i];
    archive.value(segment);
    if (!archive.is_reading()) continue;
    if (i > 0 && segment.id <= segments_[i - 1].id)
      archive.fail(Status::malformed, "ids of watched segments do not rise");
    if (segment.rest_since_ns > now_ns_ || (segment.version > 0 && segment.version_at_ns > now_ns_))
      archive.fail(Status::malformed, "a watched segment rests since a time to come");
  }
  if (archive.is_reading()) {
    if (archive.status() != Status::ok) count_ = 0;
    sorted_ = count_;
  }
}

}  // namespace sortie::mapping
