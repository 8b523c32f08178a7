// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/wire_segments.hpp"

#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

Status encode(const rt::SegmentList& list, std::int64_t seq, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  if (list.listed > rt::SegmentList::kMost || list.listed_events > rt::SegmentList::kMostEvents) {
    size = 0;
    return Status::full;
  }
  const std::span segments(list.segment, list.listed);
  const std::span featured = list.features ? segments : segments.first(0);
  const std::span events(list.event, list.listed_events);
  WireWriter writer(out);
  writer.put(kFingerprintSegments);
  writer.put(list.stamp_ns);
  writer.put(seq);
  writer.put(list.segments);
  writer.put(list.events);
  writer.put_array(list.origin_m, 3);
  writer.put_count(segments.size());
  for (const rt::ListedSegment& segment : segments) writer.put(segment.id);
  for (const rt::ListedSegment& segment : segments) writer.put(segment.voxels);
  writer.put_count(featured.size());
  for (const rt::ListedSegment& segment : featured) writer.put_array(segment.centroid_m, 3);
  for (const rt::ListedSegment& segment : featured) writer.put_array(segment.least_m, 3);
  for (const rt::ListedSegment& segment : featured) writer.put_array(segment.most_m, 3);
  for (const rt::ListedSegment& segment : featured)
    writer.put_array(segment.feature, rt::ListedSegment::kFeatures);
  writer.put_count(events.size());
  for (const rt::ListedEvent& event : events) writer.put(event.change);
  for (const rt::ListedEvent& event : events) writer.put(event.id);
  for (const rt::ListedEvent& event : events) writer.put(event.other);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, rt::SegmentList& list, std::int64_t& seq) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintSegments); type != Status::ok) return type;
  list.stamp_ns = reader.get<std::int64_t>();
  seq = reader.get<std::int64_t>();
  list.segments = reader.get<std::uint32_t>();
  list.events = reader.get<std::uint32_t>();
  reader.get_array(list.origin_m, 3);
  const std::size_t count = reader.get_count(8);
  if (reader.status() != Status::ok) return Status::malformed;
  if (count > rt::SegmentList::kMost) return Status::full;
  const std::span segments(list.segment, count);
  for (rt::ListedSegment& segment : segments) segment = {};
  for (rt::ListedSegment& segment : segments) segment.id = reader.get<std::uint32_t>();
  for (rt::ListedSegment& segment : segments) segment.voxels = reader.get<std::uint32_t>();
  const std::size_t featured_count = reader.get_count(64);
  if (reader.status() != Status::ok || (featured_count != 0 && featured_count != count))
    return Status::malformed;
  const std::span featured = segments.first(featured_count);
  for (rt::ListedSegment& segment : featured) reader.get_array(segment.centroid_m, 3);
  for (rt::ListedSegment& segment : featured) reader.get_array(segment.least_m, 3);
  for (rt::ListedSegment& segment : featured) reader.get_array(segment.most_m, 3);
  for (rt::ListedSegment& segment : featured) reader.get_array(segment.feature, rt::ListedSegment::kFeatures);
  const std::size_t events_count = reader.get_count(9);
  if (reader.status() != Status::ok || message.size() != segments_bytes(count, featured_count, events_count))
    return Status::malformed;
  if (events_count > rt::SegmentList::kMostEvents) return Status::full;
  const std::span events(list.event, events_count);
  for (rt::ListedEvent& event : events) {
    event.change = reader.get<std::uint8_t>();
    if (event.change > rt::ListedEvent::kGone) return Status::malformed;
  }
  for (rt::ListedEvent& event : events) event.id = reader.get<std::uint32_t>();
  for (rt::ListedEvent& event : events) event.other = reader.get<std::uint32_t>();
  list.listed = static_cast<std::uint32_t>(count);
  list.listed_events = static_cast<std::uint32_t>(events_count);
  list.features = featured_count > 0;
  return reader.finish();
}

}  // namespace sortie::drivers
