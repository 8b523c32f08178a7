// SPDX-License-Identifier: BSD-3-Clause
// Candidates of segments beside a sorted list of all targets.
#include <catch2/catch.hpp>
#include <random>

#include "mapping/recognition/candidates.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/target_rig.hpp"

namespace {
using namespace sortie;
using mapping::Candidate;
using testing::TargetEvent;

bool is_left_out(const mapping::CandidateQuery& query, const mapping::TargetRecord& one) {
  return query.leaves_out && one.robot == query.robot &&
         static_cast<std::int32_t>(one.last_seen_ms - query.since_ms) >= 0;
}

/// All targets that pass, sorted by what the order says.
std::vector<Candidate> sorted_targets(const mapping::TargetStore& store, const mapping::CandidateQuery& query,
                                      const mapping::CandidateConfig& config) {
  std::vector<Candidate> all;
  for (std::size_t i = 0; i < store.records().size(); ++i) {
    const mapping::TargetRecord& one = store.records()[i];
    if (one.state == mapping::TargetState::free || is_left_out(query, one)) continue;
    bool fits = true;
    for (int k = 0; k < 3; ++k)
      fits = fits && std::abs(one.descriptor.step[k] - query.descriptor.step[k]) <=
                         static_cast<int>(config.size_steps);
    const mapping::PlaceCm& at = store.places()[i];
    const double apart = std::hypot(at.x - query.prior.x, at.y - query.prior.y, at.z - query.prior.z);
    if (query.has_prior) fits = fits && apart <= query.radius_cm;
    if (!fits) continue;
    const int steps = testing::steps_between(one.descriptor, query.descriptor);
    all.push_back({static_cast<mapping::TargetIndex>(i), static_cast<std::uint16_t>(steps), one.uniqueness});
  }
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
    return std::make_tuple(a.distance, -a.uniqueness, a.target) <
           std::make_tuple(b.distance, -b.uniqueness, b.target);
  });
  return all;
}

mapping::CandidateQuery random_query(testing::TargetDraws& draws) {
  mapping::CandidateQuery query;
  query.descriptor = draws.look();
  query.has_prior = draws.whole(0, 2) == 0;
  query.prior = draws.place(2000);
  query.radius_cm = draws.whole(0, 4) == 0 ? draws.whole(0, 50) : draws.whole(0, 3000);
  query.leaves_out = draws.whole(0, 2) == 0;
  query.robot = draws.byte(0, 1);
  query.since_ms = 0xfffff000u + static_cast<std::uint32_t>(draws.whole(0, 97 * 700));
  if (draws.whole(0, 1) == 0)
    query.since_ms += static_cast<std::uint32_t>(draws.whole(-1 << 30, 1 << 30)) * 2;
  return query;
}

}  // namespace

TEST_CASE("Candidates are the first of all targets in order, whatever the budgets") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  std::uint64_t full = 0, compared = 0, ties = 0;
  for (int round = 0; round < 12; ++round) {
    mapping::TargetStoreConfig config;
    config.targets = static_cast<std::uint32_t>(draws.whole(1, 400));
    config.key_frames = 4;
    config.same_cm = 50;
    testing::OwnedTargets owned(config);
    for (const TargetEvent& event : draws.stream(config, 700)) testing::happens(owned.store, event);
    std::uint64_t some = static_cast<std::uint64_t>(draws.whole(0, 200'000));
    owned.store.run(some);
    mapping::CandidateConfig settings;
    settings.most = static_cast<std::uint32_t>(draws.whole(1, 64));
    settings.size_steps = static_cast<std::uint32_t>(draws.whole(0, 3) == 0 ? 255 : draws.whole(0, 40));
    mapping::CandidateSearch search(settings);
    for (int i = 0; i < 60; ++i) {
      INFO("round " << round << ", query " << i);
      const mapping::CandidateQuery query = random_query(draws);
      const std::vector<Candidate> all = sorted_targets(owned.store, query, settings);
      search.begin(query);
      std::uint64_t used = 0;
      for (bool done = false; !done;) {
        std::uint64_t units = static_cast<std::uint64_t>(draws.whole(0, 500));
        const std::uint64_t given = units;
        done = search.run(owned.store, units);
        used += given - units;
      }
      const std::uint64_t blocks = (owned.store.records().size() + 63) / 64;
      REQUIRE(used == blocks * 64 * mapping::CandidateSearch::kUnitsADescriptor);
      REQUIRE(search.compared() == all.size());
      REQUIRE(search.size() == std::min<std::size_t>(settings.most, all.size()));
      for (std::uint32_t k = 0; k < search.size(); ++k) {
        REQUIRE(search[k] == all[k]);
        if (k > 0 && all[k].distance == all[k - 1].distance) ++ties;
      }
      full += all.size() > settings.most ? 1 : 0;
      compared += all.size();
    }
  }
  // Far below what comes of stores that hold 200 targets of few looks on the average, with any seed.
  CHECK(full > 0);
  CHECK(ties > 0);
  CHECK(compared > 100);
}

TEST_CASE("Sizes at the ends of their range are within their gate, and no further") {
  mapping::TargetStoreConfig config;
  config.targets = 256;
  config.key_frames = 1;
  config.same_cm = 0;
  testing::OwnedTargets owned(config);
  REQUIRE(owned.store.set_key_frame(0, {}) == Status::ok);
  for (int size = 0; size < 256; ++size) {
    mapping::TargetSighting seen;
    seen.id = static_cast<std::uint32_t>(size);
    seen.descriptor.step[size % 3] = static_cast<std::uint8_t>(size);
    REQUIRE(owned.store.put(seen).target == size);
  }
  for (const int steps : {0, 1, 16, 254, 255}) {
    for (int size = 0; size < 256; ++size) {
      for (int axis = 0; axis < 3; ++axis) {
        mapping::CandidateSearch search({64, static_cast<std::uint32_t>(steps)});
        mapping::CandidateQuery query;
        query.descriptor.step[axis] = static_cast<std::uint8_t>(size);
        search.begin(query);
        std::uint64_t units = 100'000;
        const std::uint64_t before = rt::posix::heap_trap_thread_calls();
        rt::posix::heap_trap_arm();
        const bool done = search.run(owned.store, units);
        rt::posix::heap_trap_disarm();
        REQUIRE(done);
        REQUIRE(rt::posix::heap_trap_thread_calls() == before);
        std::uint32_t expected = 0;
        for (int other = 0; other < 256; ++other) {
          const bool same_axis = other % 3 == axis;
          const bool fits = same_axis ? std::abs(other - size) <= steps : other <= steps && size <= steps;
          expected += fits ? 1 : 0;
        }
        INFO("steps " << steps << ", size " << size << ", axis " << axis);
        REQUIRE(search.compared() == expected);
      }
    }
  }
}

TEST_CASE("Targets near a place at the ends of its range are those near it") {
  mapping::TargetStoreConfig config;
  config.key_frames = 2;
  testing::OwnedTargets owned(config);
  constexpr std::int32_t kFar = mapping::KeyFramePose::kFarthestCm, kEnd = 2'147'483'647;
  mapping::TargetSighting seen;
  for (const std::int32_t at : {kFar, -kFar}) {
    seen.key_frame = static_cast<std::uint16_t>(at > 0);
    REQUIRE(owned.store.set_key_frame(seen.key_frame, {{at, at, at}, {}}) == Status::ok);
    REQUIRE(owned.store.put(seen).status == Status::ok);
    ++seen.id;
  }
  mapping::CandidateSearch search({});
  const auto near = [&](std::int32_t at, std::int32_t radius) {
    mapping::CandidateQuery query;
    query.has_prior = true;
    query.prior = {at, at, at};
    query.radius_cm = radius;
    search.begin(query);
    std::uint64_t units = 1'000;
    REQUIRE(search.run(owned.store, units));
    return search.size();
  };
  CHECK(near(kFar, 0) == 1);
  CHECK(near(kFar, -1) == 0);
  const auto corner = static_cast<std::int32_t>(std::sqrt(3.0) * kFar);
  CHECK(near(0, corner) == 0);
  CHECK(near(0, corner + 1) == 2);
  for (const std::int32_t end : {kEnd, -kEnd - 1}) {
    CHECK(near(end, 100'000) == 0);
    CHECK(near(end, kEnd) == 0);  // further away than that, across
    CHECK(near(end / 2, kEnd) == 1);
  }
}

TEST_CASE("A search of candidates in an empty store is done at once and finds none") {
  testing::OwnedTargets owned({});
  REQUIRE(owned.arena.refused() == 0);
  mapping::CandidateSearch search({});
  search.begin({});
  std::uint64_t units = 0;
  CHECK(search.run(owned.store, units));
  CHECK(search.size() == 0);
  CHECK(search.config().most == 16);
}
