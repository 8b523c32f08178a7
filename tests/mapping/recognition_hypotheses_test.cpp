// SPDX-License-Identifier: BSD-3-Clause
// From correspondences to poses: planted places among wrong correspondences, and places that are not there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "mapping/recognition/set_hypotheses.hpp"
#include "tests/mapping/level_places.hpp"

namespace {
using namespace sortie;
using mapping::SetConfig;
using mapping::SetVerdict;
using mapping::SweptPair;

using rt::Vector3;
using testing::any_level_pose;
using testing::LevelPose;
using testing::miss_m;
using testing::rounded;
using testing::scattered;

/// Correspondences of a local map.
struct Scene {
  std::vector<Vector3> segments, targets;
  std::vector<SweptPair> pairs;

  void pair(std::size_t segment, std::size_t target) {
    const mapping::Correspondence c{static_cast<std::uint16_t>(segment), static_cast<std::uint16_t>(target)};
    const auto is_there = [&](const SweptPair& p) { return p.pair == c; };
    if (std::any_of(pairs.begin(), pairs.end(), is_there)) return;
    pairs.push_back({c, rounded(segments[segment]), rounded(targets[target])});
  }
  void pair_at_random(int each, testing::Draws& draws) {
    for (std::size_t s = 0; s < segments.size(); ++s) {
      for (int k = 0; k < each; ++k) {
        pair(s, static_cast<std::size_t>(draws.uniform(0, static_cast<double>(targets.size()))));
      }
    }
  }
  void add_targets(int count, testing::Draws& draws) {
    for (const Vector3& p : scattered(count, 100, draws, targets)) targets.push_back(p);
  }
};

Vector3 shaken(const Vector3& p, double by_m, testing::Draws& draws) {
  return {p.x + draws.uniform(-by_m, by_m), p.y + draws.uniform(-by_m, by_m),
          p.z + draws.uniform(-by_m, by_m)};
}

struct OwnedHypotheses {
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::SetHypotheses sets;

  explicit OwnedHypotheses(std::uint32_t pairs)
      : memory(std::size_t{pairs} * (pairs / 2 + 700) + 400'000), arena(memory), sets(pairs, arena) {}

  SetVerdict ask(const std::vector<SweptPair>& pairs, const SetConfig& config = {}) {
    REQUIRE(sets.begin(config, pairs) == Status::ok);
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(sets.run(units));
    return sets.verdict();
  }
};
}  // namespace

TEST_CASE("A place is found among wrong correspondences, with all its segments and within their noise") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedHypotheses owned(1'200);
  REQUIRE(owned.arena.refused() == 0);
  for (int run = 0; run < 40; ++run) {
    INFO("run " << run);
    const LevelPose truth = any_level_pose(draws);
    Scene scene;
    scene.segments = scattered(40, 15, draws);
    for (std::size_t i = 0; i < 14; ++i)
      scene.targets.push_back(shaken(truth(scene.segments[i]), 0.1, draws));
    scene.add_targets(300, draws);
    for (std::size_t i = 0; i < 14; ++i) scene.pair(i, i);
    scene.pair_at_random(20, draws);
    REQUIRE(owned.ask(scene.pairs) == SetVerdict::found);
    CHECK(owned.sets.proved());
    const mapping::SetHypothesis& best = owned.sets.found()[0];
    int right = 0;
    for (std::uint32_t i = 0; i < best.count; ++i) {
      const mapping::Correspondence& c = scene.pairs[best.pairs[i]].pair;
      if (c.segment == c.target && c.segment < 14) ++right;
    }
    CHECK(right == 14);
    // The worst case of 14 places off by 0.1 m: a mean of 0.1 m along each axis, and a turn on top.
    CHECK(miss_m(best.fit.place, truth, {0, 0, 0}) < 0.4);
    CHECK(miss_m(best.fit.place, truth, {5, 5, 1}) < 0.6);
  }
}

TEST_CASE("Two places with the same segments are ambiguous, in all of 1,000") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedHypotheses owned(600);
  int ambiguous = 0;
  for (int run = 0; run < 1'000; ++run) {
    Scene scene;
    scene.segments = scattered(16, 12, draws);
    const LevelPose first = any_level_pose(draws);
    LevelPose second = any_level_pose(draws);
    // A room's length apart at least: nearer ones are one place.
    second.x = first.x + (draws.uniform(0, 1) < 0.5 ? -1 : 1) * draws.uniform(3, 60);
    for (const LevelPose& pose : {first, second}) {
      for (std::size_t i = 0; i < 10; ++i) {
        scene.targets.push_back(shaken(pose(scene.segments[i]), 0.05, draws));
        scene.pair(i, scene.targets.size() - 1);
      }
    }
    scene.add_targets(60, draws);
    scene.pair_at_random(10, draws);
    if (owned.ask(scene.pairs) == SetVerdict::ambiguous) ++ambiguous;
  }
  CHECK(ambiguous == 1'000);
}

TEST_CASE("What no pose lays is refused, with its reason") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedHypotheses owned(600);
  for (int run = 0; run < 100; ++run) {
    INFO("run " << run);
    Scene mirrored, row, alone;
    // The mirror image has all distances and heights right.
    mirrored.segments = scattered(12, 12, draws);
    const LevelPose pose = any_level_pose(draws);
    for (std::size_t i = 0; i < 12; ++i) {
      const Vector3& p = mirrored.segments[i];
      mirrored.targets.push_back(pose({p.x, -p.y, p.z}));
      mirrored.pair(i, i);
    }
    const SetVerdict of_mirrored = owned.ask(mirrored.pairs);
    CHECK(of_mirrored != SetVerdict::found);
    // A row of columns.
    for (int i = 0; i < 10; ++i) {
      row.segments.push_back({4.0 * i + 0.7 * (i % 3), 0.02 * (i % 2), 0.1 * (i % 4)});
      row.targets.push_back(pose(row.segments.back()));
      row.pair(static_cast<std::size_t>(i), static_cast<std::size_t>(i));
    }
    CHECK(owned.ask(row.pairs) == SetVerdict::narrow);
    alone.segments = scattered(5, 12, draws);
    alone.add_targets(5, draws);
    for (std::size_t i = 0; i < 5; ++i) alone.pair(i, i);
    CHECK(owned.ask(alone.pairs) == SetVerdict::few);
  }
  CHECK(owned.ask({}) == SetVerdict::few);
  Scene scene;
  scene.segments = scattered(30, 12, draws);
  scene.add_targets(30, draws);
  for (std::size_t i = 0; i < 30; ++i) scene.pair(i, i);
  const SetVerdict verdict = owned.ask(scene.pairs);
  CHECK((verdict == SetVerdict::inconsistent || verdict == SetVerdict::bent));
}

TEST_CASE("A set that fills its room is a pose, but nobody knows whether it is the largest") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedHypotheses owned(600);
  constexpr std::size_t kMost = mapping::SetHypothesis::kMostPairs;
  for (const std::size_t size : {kMost - 1, kMost + 12}) {
    const LevelPose truth = any_level_pose(draws);
    Scene scene;
    scene.segments = scattered(static_cast<int>(size), 15, draws);
    for (std::size_t i = 0; i < size; ++i) {
      scene.targets.push_back(truth(scene.segments[i]));
      scene.pair(i, i);
    }
    CHECK(owned.ask(scene.pairs) == (size < kMost ? SetVerdict::found : SetVerdict::undecided));
    REQUIRE(owned.sets.found().size() == 1);
    CHECK(owned.sets.found()[0].count == std::min(size, kMost));
    CHECK(miss_m(owned.sets.found()[0].fit.place, truth, {5, 5, 1}) < 0.05);
  }
}

TEST_CASE("What fewer segments speak for makes no place ambiguous, but is told to whoever looks") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedHypotheses owned(600);
  const LevelPose truth = any_level_pose(draws);
  const LevelPose other{truth.yaw + 2.0, truth.x + 300.0, truth.y,
                        truth.z};  // farther off than all else is wide
  Scene scene;
  scene.segments = scattered(10, 15, draws);
  for (const std::size_t count : {std::size_t{10}, std::size_t{4}}) {
    for (std::size_t i = 0; i < count; ++i) {
      scene.targets.push_back((count == 10 ? truth : other)(scene.segments[i]));
      scene.pair(i, scene.targets.size() - 1);
    }
  }
  CHECK(owned.ask(scene.pairs) == SetVerdict::found);
  REQUIRE(owned.sets.found().size() == 2);
  CHECK(owned.sets.found()[0].count == 10);
  CHECK(owned.sets.found()[1].count == 4);
  CHECK(miss_m(owned.sets.found()[1].fit.place, other, scene.segments[0]) < 0.1);
  owned.sets.refuse();
  std::uint64_t units = ~std::uint64_t{0};
  REQUIRE(owned.sets.run(units));
  CHECK(owned.sets.verdict() == SetVerdict::inconsistent);
  CHECK(owned.sets.found().empty());
}

TEST_CASE("An answer depends neither on the order of the correspondences nor on the budgets") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedHypotheses owned(1'000), other(1'000);
  for (int run = 0; run < 20; ++run) {
    INFO("run " << run);
    const LevelPose truth = any_level_pose(draws);
    Scene scene;
    scene.segments = scattered(40, 15, draws);
    for (std::size_t i = 0; i < 9; ++i)
      scene.targets.push_back(shaken(truth(scene.segments[i]), 0.15, draws));
    scene.add_targets(200, draws);
    for (std::size_t i = 0; i < 9; ++i) scene.pair(i, i);
    scene.pair_at_random(15, draws);
    const SetVerdict verdict = owned.ask(scene.pairs);
    std::vector<SweptPair> shuffled = scene.pairs;
    for (std::size_t i = shuffled.size(); i > 1; --i) {
      std::swap(shuffled[i - 1],
                shuffled[static_cast<std::size_t>(draws.uniform(0, static_cast<double>(i)))]);
    }
    REQUIRE(other.sets.begin({}, shuffled) == Status::ok);
    int steps = 0;
    for (bool done = false; !done; ++steps) {
      std::uint64_t units = static_cast<std::uint64_t>(draws.uniform(1, 3'000));
      done = other.sets.run(units);
      REQUIRE(steps < 1'000'000);
    }
    CHECK(steps > 5);
    CHECK(other.sets.verdict() == verdict);
    REQUIRE(other.sets.found().size() == owned.sets.found().size());
    for (std::size_t h = 0; h < owned.sets.found().size(); ++h) {
      const mapping::SetHypothesis &a = owned.sets.found()[h], &b = other.sets.found()[h];
      REQUIRE(a.count == b.count);
      for (std::uint32_t i = 0; i < a.count; ++i) {
        CHECK(scene.pairs[a.pairs[i]].pair == shuffled[b.pairs[i]].pair);
      }
      CHECK(a.fit.place.cosine == b.fit.place.cosine);
      CHECK(a.fit.place.x_m == b.fit.place.x_m);
      CHECK(a.fit.rms_m == b.fit.rms_m);
    }
    REQUIRE(other.sets.begin({}, shuffled) == Status::ok);
    std::uint64_t few = 40;
    CHECK_FALSE(other.sets.run(few));
    other.sets.stop();
    CHECK(other.sets.verdict() == SetVerdict::undecided);
  }
}
