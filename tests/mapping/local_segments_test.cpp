// SPDX-License-Identifier: BSD-3-Clause
// Segments of a local map in rounds, and the targets that become of them: from stored bytes, from damaged
// ones.
#include "mapping/recognition/local_segments.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "mapping/recognition/target_keeper.hpp"
#include "tests/mapping/random_worlds.hpp"
#include "tests/mapping/registration_stored.hpp"

namespace {
using namespace sortie;
using mapping::PlaceCm;
using mapping::RigidPose;
using tests::EuclideanMap;

constexpr rt::Nanoseconds kSecondNs = rt::kNanosecondsPerSecond;
constexpr std::uint32_t kSlots = 512;

/// Two walls, the one at x = 2 m `columns` half cells wide.
std::vector<rt::ScanPoint> walls(int columns) {
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < 60 * 25; ++i) {
    const float a = 0.05f * static_cast<float>(i % 60), b = 0.05f * static_cast<float>(i / 60);
    if (i % 60 < columns) points.push_back({2.0f, a - 1.5f, b, 0, 0});
    points.push_back({-2.0f, a - 1.5f, b, 0, 0});
  }
  return points;
}

struct WallMap : EuclideanMap {
  WallMap() : EuclideanMap({}, {}, {2048, 16384, 4096, 8192, kSlots, 1024}) {}
  void see(int columns, rt::Tick tick) {
    const std::vector<rt::ScanPoint> points = walls(columns);
    (void)map.update(tests::scan_over(points), {}, tick);
  }
};

struct OwnedLocal {
  std::vector<std::byte> memory = std::vector<std::byte>(1 << 20);
  rt::Arena arena{memory};
  mapping::LocalSegments part{{}, kSlots, 8, arena};

  Status round(const WallMap& map, rt::Nanoseconds now_ns) {
    std::uint32_t units = 0;
    part.note(map.segmenter().labelling());
    return part.round(map.grid(), map.segmenter().graph(), map.segmenter().labelling(), now_ns, units);
  }
};

struct OwnedKeeper {
  std::vector<std::byte> memory = std::vector<std::byte>(1 << 16);
  rt::Arena arena{memory};
  mapping::TargetKeeper part{{}, small(), arena};

  static mapping::TargetStoreConfig small() {
    mapping::TargetStoreConfig config;
    config.targets = 4;
    config.key_frames = 3;
    return config;
  }
  /// Keeps a segment that is there, seen by a robot that stands still.
  void keep(const WallMap& map, const PlaceCm& place, rt::Nanoseconds now_ns) {
    mapping::WatchedSegment one;
    one.id = 7;
    one.speaks = true;
    one.version_at_ns = now_ns;
    one.place = place;
    part.keep({&one, 1}, map.grid(), {}, now_ns);
  }
};

}  // namespace

TEST_CASE("Local segments go on from stored bytes with the same next bytes") {
  WallMap map;
  OwnedLocal one, other;
  for (int r = 0; r < 16; ++r) {
    INFO("round " << r);
    map.see(r < 8 ? 30 : 60, static_cast<rt::Tick>(r));
    REQUIRE(testing::restore(other.part, testing::stored(one.part)) == Status::ok);
    REQUIRE(one.round(map, r * kSecondNs / 2) == Status::ok);
    REQUIRE(other.round(map, r * kSecondNs / 2) == Status::ok);
    REQUIRE((testing::stored(one.part) == testing::stored(other.part)));
  }
  REQUIRE(one.part.segments().size() == 2);
  CHECK(one.part.counts().versions == 3);  // one of the walls grew once
  CHECK(one.part.described().dropped == 0);
  CHECK(one.part.events_lost() == 0);
  CHECK(one.round(map, 0) == Status::time_backwards);
}

TEST_CASE("What left the map since its labelling is not taken for a segment at its origin") {
  WallMap map;
  OwnedLocal local;
  map.see(60, 1);
  REQUIRE(local.round(map, 0) == Status::ok);
  REQUIRE(local.part.segments().size() == 2);
  (void)map.map.insert(tests::scan_over({}), {{3.0, 0, 0}, {}}, 2);
  (void)map.map.insert(tests::scan_over({}), {{19.0, 0, 0}, {}}, 3);  // the wall at -2 m is now 21 m away
  REQUIRE(local.round(map, kSecondNs) == Status::ok);
  REQUIRE(local.part.segments().size() == 1);
  CHECK(local.part.segments()[0].now.place.x > 150);
}

TEST_CASE("A labelling that nobody noted is counted") {
  WallMap map;
  OwnedLocal local;
  for (int r = 0; r < 3; ++r) map.see(20 + 20 * r, static_cast<rt::Tick>(r));
  REQUIRE(map.segmenter().labelling().counts().labellings == 3);
  local.part.note(map.segmenter().labelling());
  local.part.note(map.segmenter().labelling());
  CHECK(local.part.events_lost() == 2);
}

TEST_CASE("A keeper of targets goes on from damaged bytes only with places that are true") {
  WallMap map;
  map.see(60, 1);
  OwnedKeeper one;
  one.keep(map, {100, 200, 30}, kSecondNs);
  REQUIRE(one.part.store().kept() == 1);
  REQUIRE(one.part.key_frames() == 1);
  const std::vector<std::uint8_t> good = testing::stored(one.part);
  int refused = 0;
  for (std::size_t i = 0; i < 2 * good.size(); ++i) {
    INFO("byte " << i / 2);
    std::vector<std::uint8_t> bytes = good;
    bytes[i / 2] ^= i % 2 == 0 ? 0xff : 0x01;
    OwnedKeeper other;
    if (testing::restore(other.part, bytes) != Status::ok) {
      ++refused;
      REQUIRE(other.part.key_frames() == 0);
      continue;
    }
    REQUIRE(other.part.key_frames() <= 1);
    const PlaceCm place{150, -250, 35};
    other.keep(map, place, 2 * kSecondNs);
    const mapping::TargetStore& store = other.part.store();
    for (const mapping::TargetRecord& record : store.records()) {
      if (record.state == mapping::TargetState::free || record.last_seen_ms != 2000) continue;
      const PlaceCm found = place_of(store.key_frames().latest(record.key_frame), record.offset);
      CHECK(mapping::square_apart(found, place) <= 3);
    }
  }
  CHECK(refused > 0);
}

TEST_CASE("A place in centimetres is one whatever the metres are") {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN(), kFar = 1e300;
  CHECK(mapping::to_cm({0.005, -0.005, 1.234}) == PlaceCm{1, 0, 123});
  CHECK(mapping::to_cm({kFar, -kFar, kNone}) == PlaceCm{4'000'000, -4'000'000, -4'000'000});
  WallMap map;
  OwnedKeeper owned;
  mapping::WatchedSegment one;
  one.speaks = true;
  owned.part.keep({&one, 1}, map.grid(), RigidPose{{}, {kNone, 0, 0, 0}}, 0);
  CHECK(owned.part.store().kept() == 0);
}
