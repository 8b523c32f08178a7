// SPDX-License-Identifier: BSD-3-Clause
// segments_t against lcm-gen's code: same bytes, every bit back, nothing taken that is damaged.
#include "drivers/wire_segments.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <random>

#include "sortie/segments_t.hpp"
#include "tests/drivers/message_bytes.hpp"

namespace sortie::drivers {
namespace {

std::unique_ptr<rt::SegmentList> any_segments(std::mt19937_64& random) {
  auto list = std::make_unique<rt::SegmentList>();
  const auto some = [&random] { return static_cast<float>(random() % 1'000'000) * 1e-3f - 500.0f; };
  const auto number = [&random] { return static_cast<std::uint32_t>(random() & 0x7fffffffu); };
  list->stamp_ns = static_cast<std::int64_t>(random());
  list->segments = number();
  list->events = number();
  for (double& v : list->origin_m) v = static_cast<double>(some());
  list->listed = static_cast<std::uint32_t>(random() % (rt::SegmentList::kMost + 1));
  list->listed_events = static_cast<std::uint32_t>(random() % (rt::SegmentList::kMostEvents + 1));
  list->features = list->listed > 0 && random() % 2 == 0;
  for (rt::ListedSegment& s : std::span(list->segment, list->listed)) {
    s.id = number();
    s.voxels = number();
    if (!list->features) continue;
    for (int i = 0; i < 3; ++i) {
      s.centroid_m[i] = some();
      s.least_m[i] = some();
      s.most_m[i] = some();
    }
    for (float& f : s.feature) f = some();
  }
  for (rt::SegmentEvent& e : std::span(list->event, list->listed_events))
    e = {static_cast<rt::SegmentChange>(random() % 3), number(), number()};
  return list;
}

segments_t twin_of_segments(const rt::SegmentList& list, std::int64_t seq) {
  segments_t twin{};
  twin.stamp_ns = list.stamp_ns;
  twin.seq = seq;
  twin.segments = static_cast<std::int32_t>(list.segments);
  twin.events = static_cast<std::int32_t>(list.events);
  for (int i = 0; i < 3; ++i) twin.origin[i] = list.origin_m[i];
  twin.n = static_cast<std::int32_t>(list.listed);
  twin.f = list.features ? twin.n : 0;
  for (const rt::ListedSegment& s : std::span(list.segment, list.listed)) {
    twin.id.push_back(static_cast<std::int32_t>(s.id));
    twin.voxels.push_back(static_cast<std::int32_t>(s.voxels));
    if (!list.features) continue;
    twin.centroid.emplace_back(s.centroid_m, s.centroid_m + 3);
    twin.least.emplace_back(s.least_m, s.least_m + 3);
    twin.most.emplace_back(s.most_m, s.most_m + 3);
    twin.feature.emplace_back(s.feature, s.feature + 7);
  }
  twin.m = static_cast<std::int32_t>(list.listed_events);
  for (const rt::SegmentEvent& e : std::span(list.event, list.listed_events)) {
    twin.change.push_back(static_cast<std::int8_t>(e.change));
    twin.event_id.push_back(static_cast<std::int32_t>(e.id));
    twin.event_other.push_back(static_cast<std::int32_t>(e.other));
  }
  return twin;
}

std::vector<std::uint8_t> segment_bytes(const rt::SegmentList& list, std::int64_t seq) {
  std::vector<std::uint8_t> bytes(kMaxSegmentsBytes);
  std::size_t size = 0;
  REQUIRE(encode(list, seq, bytes, size) == Status::ok);
  bytes.resize(size);
  return bytes;
}

}  // namespace

TEST_CASE("segments are written as lcm-gen writes them and come back bit for bit") {
  std::mt19937_64 random(11);
  const auto back = std::make_unique<rt::SegmentList>();
  for (std::int64_t round = 0; round < 50; ++round) {
    INFO("round " << round);
    const auto list = any_segments(random);
    const std::vector<std::uint8_t> bytes = segment_bytes(*list, round);
    REQUIRE((bytes == test::generated_bytes(twin_of_segments(*list, round))));
    std::int64_t seq = -1;
    REQUIRE(decode(bytes, *back, seq) == Status::ok);
    REQUIRE(seq == round);
    REQUIRE((segment_bytes(*back, seq) == bytes));
    std::vector<std::uint8_t> small(bytes.size() - 1);
    std::size_t none = 1;
    REQUIRE(encode(*list, round, small, none) == Status::full);
    REQUIRE(none == 0);
  }
}

TEST_CASE("damaged segments are refused and never lead outside") {
  std::mt19937_64 random(12);
  const auto back = std::make_unique<rt::SegmentList>();
  for (int round = 0; round < 20; ++round) {
    const std::vector<std::uint8_t> good = segment_bytes(*any_segments(random), 1);
    std::int64_t seq = 0;
    std::vector<std::uint8_t> longer = good;
    longer.push_back(0);
    REQUIRE(decode(longer, *back, seq) != Status::ok);
    for (int i = 0; i < 50; ++i) {
      const std::vector<std::uint8_t> cut(good.begin(),
                                          good.begin() + static_cast<std::ptrdiff_t>(random() % good.size()));
      REQUIRE(decode(cut, *back, seq) != Status::ok);
      std::vector<std::uint8_t> bad = good;
      bad[static_cast<std::size_t>(random() % bad.size())] ^= static_cast<std::uint8_t>(1 + random() % 255);
      if (decode(bad, *back, seq) == Status::ok) REQUIRE((segment_bytes(*back, seq) == bad));
    }
  }
}

TEST_CASE(
    "more segments or events than fit are told as that, and features of some segments alone are not taken") {
  std::int64_t seq = 0;
  const auto back = std::make_unique<rt::SegmentList>();
  auto list = std::make_unique<rt::SegmentList>();
  list->listed_events = rt::SegmentList::kMostEvents;
  std::vector<std::uint8_t> bytes = segment_bytes(*list, 1);
  constexpr std::size_t kEvents = segments_bytes(0, 0, 0) - 4;
  bytes[kEvents + 3] = 1;  // 257 of them
  bytes.resize(bytes.size() + 9);
  CHECK(decode(bytes, *back, seq) == Status::full);
  bytes.push_back(0);
  CHECK(decode(bytes, *back, seq) == Status::malformed);
  list->listed_events = 0;
  list->listed = 2;
  bytes = segment_bytes(*list, 1);
  bytes[segments_bytes(2, 0, 0) - 5] = 1;  // features of one of them
  bytes.resize(segments_bytes(2, 1, 0));
  CHECK(decode(bytes, *back, seq) == Status::malformed);
  list->listed = rt::SegmentList::kMost;
  bytes = segment_bytes(*list, 1);
  bytes[segments_bytes(0, 0, 0) - 9] = rt::SegmentList::kMost + 1;
  CHECK(decode(bytes, *back, seq) == Status::full);
  list->listed = rt::SegmentList::kMost + 1;
  std::size_t size = 1;
  CHECK(encode(*list, 1, bytes, size) == Status::full);
  CHECK(size == 0);
}

}  // namespace sortie::drivers
