// SPDX-License-Identifier: BSD-3-Clause
// A store of targets beside a twin that computes all from nothing: what it holds, where, and how unique.
#include <catch2/catch.hpp>
#include <random>

#include "rt/digest.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/target_rig.hpp"

namespace {
using namespace sortie;
using mapping::kNoTarget;
using mapping::TargetIndex;
using testing::TargetEvent;

/// Small, so that it overflows; more or less than a block of 64.
mapping::TargetStoreConfig small_store(testing::TargetDraws& draws) {
  mapping::TargetStoreConfig config;
  config.targets = static_cast<std::uint32_t>(draws.whole(1, 150));
  config.key_frames = static_cast<std::uint32_t>(draws.whole(1, 12));
  config.same_steps = static_cast<std::uint32_t>(draws.whole(0, 60));
  config.apart_cm = draws.whole(0, 1500);
  return config;
}

std::uint64_t digest_of_all(const mapping::TargetStore& store) {
  std::uint64_t digest = store.kept();
  for (std::size_t i = 0; i < store.records().size(); ++i) {
    digest = rt::digest_of(store.records()[i], digest);
    if (store.records()[i].state == mapping::TargetState::kept)
      digest = rt::digest_of(store.places()[i], digest);
  }
  return rt::digest_of(store.counts(), digest);
}

void run_to_the_end(mapping::TargetStore& store) {
  std::uint64_t units = ~0ull / 2;
  REQUIRE(store.run(units));
  REQUIRE(store.current());
}

void compare_records(const mapping::TargetStore& store, const testing::TargetTwin& twin) {
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < twin.kept.size(); ++i) {
    INFO("target " << i);
    const bool there = i < store.records().size() && store.records()[i].state == mapping::TargetState::kept;
    REQUIRE(there == twin.kept[i].has_value());
    if (!there) continue;
    ++kept;
    const mapping::TargetRecord& one = store.records()[i];
    const mapping::TargetSighting& seen = twin.kept[i]->seen;
    REQUIRE(one.id == seen.id);
    REQUIRE(one.robot == seen.robot);
    REQUIRE(one.version == seen.version);
    REQUIRE(one.voxels == seen.voxels);
    REQUIRE(one.last_seen_ms == seen.stamp_ms);
    REQUIRE(one.key_frame == seen.key_frame);
    REQUIRE(one.offset == seen.offset);
    REQUIRE(one.descriptor == seen.descriptor);
    REQUIRE(one.views == twin.kept[i]->views);
    REQUIRE(store.find(one.robot, one.id) == i);
  }
  REQUIRE(store.kept() == kept);
}

void compare_all(const mapping::TargetStore& store, const testing::TargetTwin& twin) {
  compare_records(store, twin);
  for (std::size_t i = 0; i < twin.kept.size(); ++i) {
    if (!twin.kept[i]) continue;
    INFO("target " << i);
    const auto at = twin.place(*twin.kept[i]);
    const mapping::PlaceCm& place = store.places()[i];
    REQUIRE((place.x == at.x && place.y == at.y && place.z == at.z));
    const auto [steps, nearest] = twin.uniqueness(i);
    REQUIRE(store.records()[i].uniqueness == steps);
    REQUIRE(store.records()[i].nearest == nearest);
  }
}

}  // namespace

TEST_CASE("A store of targets holds what its twin holds, with the uniqueness of a batch") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  mapping::TargetCounts counts;
  for (int round = 0; round < 25; ++round) {
    INFO("round " << round);
    const mapping::TargetStoreConfig config = small_store(draws);
    testing::OwnedTargets owned(config);
    REQUIRE(owned.arena.refused() == 0);
    testing::TargetTwin twin(config);
    int event_number = 0;
    for (const TargetEvent& event : draws.stream(config, 600)) {
      INFO("event " << event_number++);
      testing::happens(owned.store, event);
      twin.happens(event);
      std::uint64_t units = static_cast<std::uint64_t>(draws.whole(0, 400));
      owned.store.run(units);
      if (event_number % 20 == 0) compare_records(owned.store, twin);
      if (event_number % 60 != 0) continue;
      run_to_the_end(owned.store);
      compare_all(owned.store, twin);
    }
    REQUIRE(owned.store.counts().evicted == twin.evicted);
    counts.evicted += owned.store.counts().evicted;
    counts.renewed += owned.store.counts().renewed;
    counts.adopted += owned.store.counts().adopted;
  }
  // Of 15,000 events; far below what comes of stores of any size.
  CHECK(counts.evicted > 100);
  CHECK(counts.renewed > 100);
  CHECK(counts.adopted > 0);
}

TEST_CASE("Budgets change nothing of what a store of targets comes to") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  for (int round = 0; round < 20; ++round) {
    INFO("round " << round);
    const mapping::TargetStoreConfig config = small_store(draws);
    const std::vector<TargetEvent> stream = draws.stream(config, 400);
    std::vector<std::uint64_t> ends;
    for (const int most : {0, 1, 130, 2000, 1 << 20}) {
      testing::OwnedTargets owned(config);
      for (const TargetEvent& event : stream) {
        testing::happens(owned.store, event);
        std::uint64_t units = static_cast<std::uint64_t>(draws.whole(0, most));
        const std::uint64_t given = units;
        owned.store.run(units);
        REQUIRE(units <= given);
      }
      run_to_the_end(owned.store);
      ends.push_back(digest_of_all(owned.store));
    }
    for (const std::uint64_t end : ends) REQUIRE(end == ends.front());
  }
}

TEST_CASE("A store of targets comes to the same digest with every compiler and on every board") {
  testing::TargetDraws draws(20240);
  mapping::TargetStoreConfig config;
  config.targets = 130;
  config.key_frames = 9;
  testing::OwnedTargets owned(config);
  for (const TargetEvent& event : draws.stream(config, 1500)) {
    testing::happens(owned.store, event);
    std::uint64_t units = 3000;
    owned.store.run(units);
  }
  run_to_the_end(owned.store);
  CHECK(digest_of_all(owned.store) == 0xe67559573684467eull);
}

TEST_CASE("Readers see places that are all from the same key frames, old or new") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  mapping::TargetStoreConfig config;
  config.targets = 200;
  config.key_frames = 5;
  testing::OwnedTargets owned(config);
  mapping::TargetStore& store = owned.store;
  std::vector<mapping::KeyFramePose> poses(config.key_frames);
  std::vector<std::vector<mapping::KeyFramePose>> history;
  for (int tick = 0; tick < 600; ++tick) {
    INFO("tick " << tick);
    if (tick == 0 || draws.whole(0, 9) == 0) {  // a correction moves all at once
      for (std::uint16_t k = 0; k < config.key_frames; ++k) {
        poses[k] = draws.pose();
        REQUIRE(store.set_key_frame(k, poses[k]) == Status::ok);
      }
      history.push_back(poses);
    }
    TargetEvent event = draws.event(config, static_cast<std::uint32_t>(tick));
    event.kind = TargetEvent::sighting;
    testing::happens(store, event);
    std::uint64_t units = static_cast<std::uint64_t>(draws.whole(0, 100));
    store.run(units);
    const auto is_shown = [&](const std::vector<mapping::KeyFramePose>& of) {
      for (std::uint16_t k = 0; k < config.key_frames; ++k) {
        if (!(store.key_frames().shown(k) == of[k])) return false;
      }
      return true;
    };
    REQUIRE(std::any_of(history.begin(), history.end(), is_shown));
    for (std::size_t i = 0; i < store.records().size(); ++i) {
      const mapping::TargetRecord& one = store.records()[i];
      if (one.state == mapping::TargetState::kept)
        REQUIRE(store.places()[i] == mapping::place_of(store.key_frames().shown(one.key_frame), one.offset));
    }
  }
  CHECK(store.key_frames().tables_shown() > 5);
}

TEST_CASE("A place goes to its key frame and back to a centimetre") {
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  for (int round = 0; round < 10'000; ++round) {
    mapping::KeyFramePose frame;
    const double yaw = draws.draws.uniform(-4, 4), length = std::exp(draws.draws.uniform(-20, 20));
    REQUIRE(mapping::heading_of(length * std::cos(yaw), length * std::sin(yaw), frame.heading));
    REQUIRE(frame.usable());
    frame.place = draws.place(1 << 28);
    const mapping::PlaceCm offset = draws.place(mapping::kFarthestOffsetCm);
    const mapping::PlaceCm place = mapping::place_of(frame, offset);
    // Half a centimetre by rounding; 2^-31 of 2 * 2^20 cm, and as much of the arithmetic, by the heading.
    CHECK(std::fabs(place.x - (frame.place.x + std::cos(yaw) * offset.x - std::sin(yaw) * offset.y)) < 0.51);
    CHECK(std::fabs(place.y - (frame.place.y + std::sin(yaw) * offset.x + std::cos(yaw) * offset.y)) < 0.51);
    const mapping::PlaceCm back = mapping::offset_of(frame, place);
    CHECK(std::abs(back.x - offset.x) <= 1);
    CHECK(std::abs(back.y - offset.y) <= 1);
    CHECK(back.z == offset.z);
    const mapping::PlaceCm again = mapping::place_of(frame, back);
    CHECK(std::abs(again.x - place.x) <= 1);
    CHECK(std::abs(again.y - place.y) <= 1);
  }
  mapping::Heading heading;
  CHECK(mapping::heading_of(0.0, -3.0, heading));
  CHECK(heading == mapping::Heading{0, -mapping::Heading::kOne});
  CHECK_FALSE(mapping::heading_of(0.0, 0.0, heading));
  CHECK_FALSE(mapping::heading_of(std::nan(""), 1.0, heading));
  CHECK_FALSE(mapping::heading_of(INFINITY, 1.0, heading));
  CHECK(heading == mapping::Heading{0, -mapping::Heading::kOne});
}

TEST_CASE("A store of targets takes nothing that cannot be, and no heap") {
  mapping::TargetStoreConfig config;
  config.targets = 70;
  config.key_frames = 2;
  testing::OwnedTargets owned(config);
  mapping::TargetStore& store = owned.store;
  CHECK(store.put({}).status == Status::out_of_range);
  mapping::KeyFramePose pose;
  CHECK(store.set_key_frame(2, pose) == Status::out_of_range);
  pose.heading.cosine = 17;
  CHECK(store.set_key_frame(0, pose) == Status::out_of_range);
  pose.heading = {};
  pose.place.z = mapping::KeyFramePose::kFarthestCm + 1;
  CHECK(store.set_key_frame(0, pose) == Status::out_of_range);
  pose.place = {};
  REQUIRE(store.set_key_frame(0, pose) == Status::ok);
  mapping::TargetSighting seen;
  seen.offset.x = -mapping::kFarthestOffsetCm - 1;
  CHECK(store.put(seen).status == Status::out_of_range);
  CHECK(store.counts().refused == 2);
  CHECK_FALSE(store.remove(0));
  CHECK_FALSE(store.remove(kNoTarget));

  const std::uint64_t before = rt::posix::heap_trap_thread_calls();
  rt::posix::heap_trap_arm();
  for (std::uint32_t id = 0; id < 200; ++id) {  // all looks alike, all far apart
    seen.id = id;
    seen.offset = {1000 * static_cast<std::int32_t>(id), 0, 0};
    (void)store.put(seen);
    std::uint64_t units = 1000;
    store.run(units);
  }
  rt::posix::heap_trap_disarm();
  CHECK(rt::posix::heap_trap_thread_calls() == before);
  CHECK(store.kept() == 70);
  CHECK(store.counts().evicted == 130);
  run_to_the_end(store);
  for (const mapping::TargetRecord& one : store.records()) CHECK(one.uniqueness == 0);

  std::vector<std::byte> little(1000);
  rt::Arena arena(little);
  mapping::TargetStore none(config, arena);
  seen.offset = {};
  CHECK(none.set_key_frame(0, {}) == Status::ok);
  CHECK(none.put(seen).status == Status::full);
  CHECK(none.records().empty());
}
