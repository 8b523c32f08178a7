// SPDX-License-Identifier: BSD-3-Clause
// A store of targets that goes on from stored bytes beside the one that never stopped; and hostile bytes.
#include <catch2/catch.hpp>
#include <random>

#include "mapping/recognition/candidates.hpp"
#include "tests/mapping/registration_stored.hpp"
#include "tests/mapping/target_rig.hpp"

namespace {
using namespace sortie;
using testing::restore;
using testing::stored;
using testing::TargetEvent;

mapping::TargetStoreConfig stored_config() {
  mapping::TargetStoreConfig config;
  config.targets = 90;
  config.key_frames = 6;
  return config;
}

/// Whatever was read: nothing that follows from it leads outside.
void go_on(mapping::TargetStore& store, testing::TargetDraws& draws) {
  for (const mapping::TargetRecord& one : store.records()) {
    if (one.nearest != mapping::kNoTarget) REQUIRE(one.nearest < store.records().size());
  }
  for (int i = 0; i < 20; ++i) {
    testing::happens(store, draws.event(store.config(), 5u));
    std::uint64_t units = 5000;
    store.run(units);
  }
  mapping::CandidateSearch search({64, 255});
  search.begin({draws.look()});
  std::uint64_t units = ~0ull / 2;
  REQUIRE(search.run(store, units));
  for (std::uint32_t i = 0; i < search.size(); ++i) REQUIRE(search[i].target < store.records().size());
  units = ~0ull / 2;
  REQUIRE(store.run(units));
}

}  // namespace

TEST_CASE("A store of targets goes on from stored bytes with the same next bytes") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  testing::OwnedTargets one(stored_config()), other(stored_config());
  int at_rest = 0, shown = 0;
  for (int tick = 0; tick < 500; ++tick) {
    INFO("tick " << tick);
    const std::vector<std::uint8_t> before = stored(one.store);
    // Taken over each time, into a store that has gone on with something else.
    REQUIRE(restore(other.store, before) == Status::ok);
    REQUIRE((stored(other.store) == before));
    REQUIRE(other.store.kept() == one.store.kept());
    REQUIRE(other.store.current() == one.store.current());
    for (std::size_t i = 0; i < one.store.records().size(); ++i) {
      if (one.store.records()[i].state == mapping::TargetState::kept)
        REQUIRE(one.store.places()[i] == other.store.places()[i]);
    }
    const TargetEvent event = draws.event(one.store.config(), static_cast<std::uint32_t>(tick));
    std::uint64_t units = static_cast<std::uint64_t>(draws.whole(0, tick % 3 == 0 ? 5000 : 200));
    for (mapping::TargetStore* store : {&one.store, &other.store}) {
      testing::happens(*store, event);
      std::uint64_t left = units;
      store->run(left);
    }
    REQUIRE((stored(other.store) == stored(one.store)));
    at_rest += one.store.current() ? 1 : 0;
    shown += one.store.key_frames().current() ? 1 : 0;
    go_on(other.store, draws);
  }
  // Bytes were taken at rest, while places were made, and while targets were compared: of 500 times, of which
  // a third has units for all that one event leads to, and 30 move a key frame.
  CHECK(at_rest > 0);
  CHECK(shown > at_rest);
  CHECK(shown < 500);
  CHECK(one.store.counts().evicted > 0);
}

TEST_CASE("Bytes that are no store's of targets leave it empty, or are a state that it can go on from") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  testing::OwnedTargets one(stored_config()), victim(stored_config());
  for (const TargetEvent& event : draws.stream(one.store.config(), 150)) testing::happens(one.store, event);
  REQUIRE(one.store.set_key_frame(0, draws.pose()) == Status::ok);
  std::uint64_t begun = 400;
  one.store.run(begun);
  const std::vector<std::uint8_t> good = stored(one.store);
  const auto is_empty = [&victim] {
    return victim.store.records().empty() && victim.store.kept() == 0 && victim.store.current() &&
           !victim.store.key_frames().knows(0);
  };
  for (std::size_t keep = 0; keep < good.size(); keep += 1 + good.size() / 97) {
    CHECK(restore(victim.store, std::span(good).first(keep)) != Status::ok);
    CHECK(is_empty());
  }
  mapping::TargetStoreConfig larger = stored_config();
  larger.targets = 91;
  testing::OwnedTargets other(larger);
  CHECK(restore(other.store, good) == Status::malformed);
  int refused = 0;
  for (int round = 0; round < 3000; ++round) {
    INFO("round " << round);
    std::vector<std::uint8_t> bytes = good;
    // Where a few bytes say much: the ends, besides anywhere.
    const auto size = static_cast<std::int32_t>(bytes.size());
    for (int i = draws.whole(1, 4); i > 0; --i) {
      const std::int32_t at = round % 3 == 0   ? draws.whole(0, 80)
                              : round % 3 == 1 ? draws.whole(size - 300, size - 1)
                                               : draws.whole(0, size - 1);
      bytes[static_cast<std::size_t>(at)] = draws.byte(0, 255);
    }
    if (restore(victim.store, bytes) != Status::ok) {
      ++refused;
      REQUIRE(is_empty());
    }
    go_on(victim.store, draws);
  }
  CHECK(refused > 100);
}
