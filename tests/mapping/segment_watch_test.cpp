// SPDX-License-Identifier: BSD-3-Clause
// When segments may speak: a twin that remembers everything agrees on every round of random streams.
#include "mapping/recognition/segment_watch.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "tests/mapping/registration_world.hpp"

namespace {
using namespace sortie;
using mapping::PlaceCm;
using mapping::SegmentChange;
using mapping::SegmentDescriptor;
using mapping::SegmentEvent;
using mapping::SegmentId;
using mapping::SegmentSighting;
using mapping::SegmentWatch;
using mapping::SegmentWatchConfig;
using mapping::WatchedSegment;

constexpr rt::Nanoseconds kS = rt::kNanosecondsPerSecond;

struct OwnedWatch {
  std::vector<std::byte> memory = std::vector<std::byte>(1 << 20);
  rt::Arena arena{memory};
  SegmentWatch watch;
  explicit OwnedWatch(const SegmentWatchConfig& config = {}) : watch(config, arena) {}
};

SegmentDescriptor looks(int kind) {
  SegmentDescriptor d;
  d.step[kind % 24] = static_cast<std::uint8_t>(1 + kind / 24);
  return d;
}

/// One segment's rounds, all of them.
struct Life {
  struct Round {
    rt::Nanoseconds at{};
    SegmentSighting seen;
    bool disturbed{};  ///< by a merge or a cut since the round before
  };
  std::vector<Round> rounds;
  struct Version {
    rt::Nanoseconds at{};
    PlaceCm place;
    SegmentDescriptor descriptor;
  };
  std::vector<Version> versions;
  std::size_t told_at{};  ///< rounds when it was described last; 0: never

  /// Whether the last round finds it at rest: back to the round that its rest began at.
  bool rests(const SegmentWatchConfig& c) const {
    std::size_t begin = 0;
    for (std::size_t i = 1; i < rounds.size(); ++i) {
      const PlaceCm& a = rounds[i].seen.place;
      // A disturbed one rests where it was the round before, from now on; unless it is off that, too.
      const PlaceCm& b = rounds[i].disturbed ? rounds[i - 1].seen.place : place_of_rest(begin);
      if (rounds[i].disturbed) begin = i, from_before = true;
      if (std::hypot(a.x - b.x, a.y - b.y, a.z - b.z) >= c.drift_cm) begin = i, from_before = false;
    }
    from_before = false;
    return rounds.back().at - rounds[begin].at >= c.rest_ns;
  }
  const PlaceCm& place_of_rest(std::size_t begin) const {
    return from_before ? rounds[begin - 1].seen.place : rounds[begin].seen.place;
  }
  mutable bool from_before{};

  bool speaks() const {
    if (told_at == 0) return false;
    for (std::size_t i = told_at; i < rounds.size(); ++i) {
      if (rounds[i].disturbed) return false;
    }
    return true;
  }
  bool wanted(const SegmentWatchConfig& c) const {
    const Round& last = rounds.back();
    if (last.seen.voxels < c.min_voxels || !last.seen.whole || !rests(c)) return false;
    const bool same = speaks() && rounds[told_at - 1].seen.voxels == last.seen.voxels &&
                      rounds[told_at - 1].seen.place == last.seen.place;
    return !same && (versions.empty() || last.at - versions.back().at >= c.version_ns);
  }
  bool tell(const SegmentDescriptor& d) {
    told_at = rounds.size();
    const Round& last = rounds.back();
    if (!versions.empty() && versions.back().place == last.seen.place && versions.back().descriptor == d)
      return false;
    versions.push_back({last.at, last.seen.place, d});
    return true;
  }
};

SegmentSighting sighting(SegmentId id, std::uint32_t voxels = 200, PlaceCm place = {}, bool whole = true) {
  return {id, voxels, place, whole};
}

/// A round with one or some segments.
void round(SegmentWatch& watch, rt::Nanoseconds now, const std::vector<SegmentSighting>& all,
           const std::vector<SegmentEvent>& events = {}) {
  REQUIRE(watch.begin(now) == Status::ok);
  watch.note(events);
  for (const SegmentSighting& s : all) watch.see(s);
  watch.end();
}

}  // namespace

TEST_CASE(
    "Of segments that grow, move, merge and leave, a watch knows what a twin with a full memory knows") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  const auto chance = [&draws](double p) { return draws.uniform(0, 1) < p; };
  const auto one_of = [&draws](std::size_t n) {
    return static_cast<std::size_t>(draws.uniform(0, 1) * static_cast<double>(n));
  };
  const auto whole = [&draws](double low, double high) {
    return static_cast<std::int32_t>(std::floor(draws.uniform(low, high)));
  };
  std::uint64_t versions = 0, silenced = 0;
  for (int trial = 0; trial < 20; ++trial) {
    SegmentWatchConfig config;
    config.min_voxels = static_cast<std::uint32_t>(whole(50, 150));
    config.drift_cm = static_cast<std::uint32_t>(whole(1, 10));
    config.rest_ns = whole(0, 3) * kS / 2;
    config.version_ns = whole(0, 5) * kS;
    config.watched = 64;
    OwnedWatch owned(config);
    SegmentWatch& watch = owned.watch;
    std::vector<SegmentSighting> world;
    std::map<SegmentId, Life> lives;
    SegmentId next = 1;
    rt::Nanoseconds now = whole(-5, 5) * kS;
    for (int r = 0; r < 150; ++r) {
      now += whole(1, 15) * kS / 10;
      std::vector<SegmentEvent> events;
      std::vector<SegmentId> disturbed;
      while (world.size() < 30 && chance(0.4)) {
        SegmentId cut_from = 0;
        if (!world.empty() && chance(0.3)) disturbed.push_back(cut_from = world[one_of(world.size())].id);
        events.push_back({SegmentChange::born, next, cut_from});
        world.push_back(sighting(next++, static_cast<std::uint32_t>(whole(20, 300)),
                                 {whole(-999, 999), whole(-999, 999), 0}, chance(0.8)));
      }
      for (std::size_t i = 0; i < world.size();) {
        SegmentSighting& s = world[i];
        if (chance(0.2)) s.place.x += whole(-4, 5);
        if (chance(0.1)) s.place.z += whole(-9, 9);
        if (chance(0.2)) s.voxels += static_cast<std::uint32_t>(whole(0, 9));
        if (chance(0.02)) s.whole = !s.whole;
        if (!chance(0.01) || world.size() < 2) {
          ++i;
          continue;
        }
        const SegmentId gone = s.id;
        world.erase(world.begin() + static_cast<std::ptrdiff_t>(i));
        const SegmentId to = world[one_of(world.size())].id;
        const bool merged = chance(0.5);
        if (merged) disturbed.push_back(to);
        // The event of what is gone may have been lost.
        if (merged || chance(0.7))
          events.push_back({merged ? SegmentChange::renamed : SegmentChange::gone, gone, merged ? to : 0});
      }
      for (std::size_t i = world.size(); i > 1; --i) std::swap(world[i - 1], world[one_of(i)]);
      round(watch, now, world, events);

      std::map<SegmentId, Life> still;
      for (const SegmentSighting& s : world) {
        const bool known = lives.count(s.id) > 0;
        if (!known && s.voxels < config.min_voxels) continue;
        Life& life = still[s.id] = lives[s.id];
        life.rounds.push_back({now, s, known && std::count(disturbed.begin(), disturbed.end(), s.id) > 0});
      }
      lives = still;
      REQUIRE(watch.segments().size() == lives.size());
      std::size_t at = 0;
      for (auto& [id, life] : lives) {
        INFO("trial " << trial << ", round " << r << ", id " << id);
        const WatchedSegment& segment = watch.segments()[at++];
        REQUIRE(segment.id == id);
        REQUIRE(watch.find(id) == &segment);
        REQUIRE(segment.wanted == life.wanted(config));
        REQUIRE(segment.speaks == life.speaks());
        REQUIRE(segment.version == life.versions.size());
        if (!segment.wanted || chance(0.3)) continue;
        const SegmentDescriptor d = looks(chance(0.7) ? static_cast<int>(id % 7) : whole(0, 40));
        const bool fresh = life.tell(d);
        REQUIRE(watch.describe(id, d) == fresh);
        REQUIRE_FALSE(watch.describe(id, looks(50)));  // nobody asked twice
        REQUIRE(segment.descriptor == life.versions.back().descriptor);
        REQUIRE(segment.place == life.versions.back().place);
      }
    }
    versions += watch.counts().versions;
    silenced += watch.counts().silenced;
  }
  CHECK(versions > 100);  // 150 rounds of 20 worlds: what was to be tried was tried
  CHECK(silenced > 10);
}

TEST_CASE("A segment speaks after a second at rest, and again two seconds later if it is another one") {
  OwnedWatch owned;
  SegmentWatch& watch = owned.watch;
  const auto see = [&watch](double at_s, const SegmentSighting& s) {
    round(watch, static_cast<rt::Nanoseconds>(at_s * 1e9), {s});
    return watch.find(1) != nullptr && watch.find(1)->wanted;
  };
  CHECK_FALSE(see(0.0, sighting(1, 99)));
  CHECK(watch.segments().empty());
  CHECK_FALSE(see(0.5, sighting(1)));
  CHECK_FALSE(see(1.4, sighting(1, 200, {3, 3, 2})));  // 4.7 cm off: it rests since 0.5 s
  CHECK(see(1.5, sighting(1)));
  CHECK(watch.describe(1, looks(1)));
  CHECK(watch.find(1)->version == 1);
  CHECK_FALSE(see(3.0, sighting(1, 201)));  // too early
  CHECK_FALSE(see(3.5, sighting(1, 200)));  // nothing new
  CHECK(see(3.6, sighting(1, 201)));
  CHECK_FALSE(watch.describe(1, looks(1)));
  CHECK(watch.counts().unchanged == 1);
  CHECK(see(4.0, sighting(1, 202)));  // the version is old enough, whoever looked since
  CHECK(watch.describe(1, looks(2)));
  CHECK_FALSE(see(6.0, sighting(1, 203, {5, 0, 0})));  // 5 cm: it moved
  CHECK_FALSE(see(7.0, sighting(1, 203, {5, 0, 0}, false)));
  CHECK(watch.find(1)->speaks);
  CHECK(see(7.1, sighting(1, 203, {5, 0, 0})));
  CHECK(watch.begin(1) == Status::time_backwards);
  CHECK(watch.describe(1, looks(2)));  // the same looks, at another place
  CHECK(watch.find(1)->version == 3);
  CHECK(watch.counts().early == 1);
  CHECK(watch.counts().known == 1);
  CHECK(watch.counts().cut_off == 1);
}

TEST_CASE("A merge and a cut silence a segment, and its version goes on counting") {
  for (const SegmentEvent& event :
       {SegmentEvent{SegmentChange::renamed, 9, 1}, SegmentEvent{SegmentChange::born, 9, 1}}) {
    OwnedWatch owned;
    SegmentWatch& watch = owned.watch;
    round(watch, 0, {sighting(1)});
    round(watch, kS, {sighting(1)});
    REQUIRE(watch.describe(1, looks(1)));
    round(watch, 2 * kS, {sighting(1)}, {event});
    CHECK_FALSE(watch.find(1)->speaks);
    CHECK_FALSE(watch.find(1)->wanted);
    round(watch, 3 * kS, {sighting(1)});
    REQUIRE(watch.find(1)->wanted);
    CHECK(watch.describe(1, looks(2)));
    CHECK(watch.find(1)->version == 2);
    CHECK(watch.find(1)->speaks);
    CHECK(watch.counts().silenced == 1);
  }
}

TEST_CASE("A full table refuses and counts, and takes in when there is room") {
  SegmentWatchConfig config;
  config.watched = 3;
  OwnedWatch owned(config);
  SegmentWatch& watch = owned.watch;
  round(watch, 0, {sighting(5), sighting(3), sighting(9), sighting(1), sighting(5)});
  REQUIRE(watch.segments().size() == 3);
  CHECK(watch.segments()[0].id == 3);
  CHECK(watch.segments()[2].id == 9);
  CHECK(watch.counts().refused == 1);
  round(watch, 1, {sighting(9), sighting(5), sighting(1)});
  CHECK(watch.segments().size() == 2);
  CHECK(watch.counts().refused == 2);
  CHECK(watch.counts().forgotten == 1);
  round(watch, 2, {sighting(9), sighting(5), sighting(1)});
  REQUIRE(watch.segments().size() == 3);
  CHECK(watch.segments()[0].id == 1);
  config.watched = 0;
  OwnedWatch none(config);
  round(none.watch, 0, {sighting(5)});
  CHECK(none.watch.find(5) == nullptr);
}

TEST_CASE("A watch goes on from its bytes, and damaged ones lead nowhere") {
  OwnedWatch owned, other;
  round(owned.watch, 0, {sighting(1), sighting(4, 300, {1, 2, 3})});
  round(owned.watch, kS, {sighting(1), sighting(4, 300, {1, 2, 3})});
  REQUIRE(owned.watch.describe(4, looks(7)));
  rt::Archive size = rt::Archive::measuring();
  owned.watch.archive(size);
  REQUIRE(size.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size.bytes()));
  rt::Archive out = rt::Archive::writing(bytes);
  owned.watch.archive(out);
  REQUIRE(out.status() == Status::ok);
  rt::Archive in = rt::Archive::reading(bytes);
  other.watch.archive(in);
  REQUIRE(in.status() == Status::ok);
  for (SegmentWatch* watch : {&owned.watch, &other.watch}) {
    round(*watch, 3 * kS, {sighting(4, 301, {1, 2, 3}), sighting(1)});
    REQUIRE(watch->segments().size() == 2);
    CHECK(watch->find(4)->wanted);
    CHECK(watch->find(4)->speaks);
    CHECK(watch->find(4)->descriptor == looks(7));
    CHECK_FALSE(watch->describe(4, looks(7)));
  }
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::vector<std::uint8_t> damaged = bytes;
    damaged[i] ^= 0xff;
    OwnedWatch third;
    rt::Archive reading = rt::Archive::reading(damaged);
    third.watch.archive(reading);
    CHECK((reading.status() == Status::ok || third.watch.segments().empty()));
    CHECK(third.watch.segments().size() <= 2);
    // Whatever the times, all are at rest at the end of them but for what is another place.
    constexpr rt::Nanoseconds kEnd = std::numeric_limits<rt::Nanoseconds>::max();
    const std::uint64_t restless = third.watch.counts().restless;
    round(third.watch, kEnd, {sighting(4, 301, {1, 2, 3}), sighting(1)});
    const auto moved = std::ranges::count(third.watch.segments(), kEnd, &WatchedSegment::rest_since_ns);
    CHECK(third.watch.counts().restless - restless == static_cast<std::uint64_t>(moved));
  }
}
