// SPDX-License-Identifier: BSD-3-Clause
// Places that come near the best one are seen behind whatever else agrees, and what is left says so.
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
using mapping::SetVerdict;
using mapping::SweptPair;

using rt::Vector3;
using testing::rounded;

/// Segments, and targets that each belong to one of them; places are far from each other.
struct RivalScene {
  std::vector<Vector3> segments;
  std::vector<SweptPair> pairs;

  void put(std::size_t segment, const Vector3& at, double yaw, int place) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const Vector3 there{c * at.x - s * at.y + 200.0 * place, s * at.x + c * at.y, at.z};
    const auto target = static_cast<std::uint16_t>(pairs.size());
    pairs.push_back(
        {{static_cast<std::uint16_t>(segment), target}, rounded(segments[segment]), rounded(there)});
  }
  /// The first so many segments as they are, at a place.
  void place(std::size_t count, double yaw, int place) {
    for (std::size_t i = 0; i < count; ++i) put(i, segments[i], yaw, place);
  }
  void shuffle(testing::Draws& draws) {
    for (std::size_t i = pairs.size(); i > 1; --i)
      std::swap(pairs[i - 1], pairs[static_cast<std::size_t>(draws.uniform(0, static_cast<double>(i)))]);
  }
};

/// Points on a spiral about the middle, 1.5 m apart and more, shaken by up to 0.3 m: nearly nothing of them
/// agrees with its mirror image.
std::vector<Vector3> spiral(int count, testing::Draws& draws) {
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.4 * i, radius = 2.0 * std::sqrt(1.0 + i);
    points.push_back({radius * std::cos(angle) + draws.uniform(-0.3, 0.3),
                      radius * std::sin(angle) + draws.uniform(-0.3, 0.3), draws.uniform(0, 2)});
  }
  return points;
}

struct RivalSearch {
  std::vector<std::byte> memory = std::vector<std::byte>(1 << 20);
  rt::Arena arena{memory};
  mapping::SetHypotheses sets{400, arena};

  RivalSearch() { REQUIRE(arena.refused() == 0); }
  SetVerdict run() {
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(sets.run(units));
    return sets.verdict();
  }
  SetVerdict ask(const RivalScene& scene) {
    REQUIRE(sets.begin({}, scene.pairs) == Status::ok);
    return run();
  }
};
}  // namespace

TEST_CASE("Another place is seen behind as many mirror images of it as there are") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  RivalSearch owned;
  for (int run = 0; run < 40; ++run) {
    INFO("run " << run);
    RivalScene scene;
    scene.segments = spiral(12, draws);
    scene.place(12, draws.uniform(-3, 3), 0);
    for (int mirror = 1; mirror <= 9; ++mirror) {
      const double yaw = draws.uniform(-3, 3);
      for (std::size_t i = 0; i < 11; ++i) {
        const Vector3& p = scene.segments[i];
        scene.put(i, {p.x, -p.y, p.z}, yaw, mirror);
      }
    }
    scene.shuffle(draws);
    CHECK(owned.ask(scene) == SetVerdict::found);
    scene.place(10, draws.uniform(-3, 3), 11);
    CHECK(owned.ask(scene) == SetVerdict::ambiguous);
  }
}

TEST_CASE("Another place is seen in a set that agrees two by two, but is not laid as a whole") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  RivalSearch owned;
  for (int run = 0; run < 100; ++run) {
    INFO("run " << run);
    RivalScene scene;
    for (int i = 0; i < 9; ++i)
      scene.segments.push_back({draws.uniform(-2, 2), draws.uniform(-2, 2), draws.uniform(0, 2)});
    for (const Vector3& far : {Vector3{30, 0.3, 1}, {-30, -0.3, 1}, {31, 2, 0}, {-31, 1, 0}})
      scene.segments.push_back(far);
    scene.place(10, draws.uniform(-3, 3), 0);
    // At the second place what is far away stands 1.6 m beside, square to where it is seen: the distances are
    // the same to 0.2 m.
    const double yaw = draws.uniform(-3, 3);
    for (std::size_t i = 0; i < 13; ++i) {
      Vector3 p = scene.segments[i];
      if (i >= 9) p.y += 1.6;
      scene.put(i, p, yaw, 1);
    }
    scene.shuffle(draws);
    CHECK(owned.ask(scene) == SetVerdict::ambiguous);
  }
}

TEST_CASE("Another place is seen behind sets of which a pose lays little") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  RivalSearch owned;
  for (int run = 0; run < 100; ++run) {
    INFO("run " << run);
    RivalScene scene;
    scene.segments = spiral(10, draws);
    scene.place(10, draws.uniform(-3, 3), 0);
    for (const int place : {1, 2}) {
      const double yaw = draws.uniform(-3, 3);
      // Six as they are and three higher: the pose between them lays those six alone.
      for (std::size_t i = 0; i < 9; ++i) {
        Vector3 p = scene.segments[i];
        if (i % 3 == 2) p.z += 0.75;
        scene.put(i, p, yaw, place);
      }
    }
    scene.shuffle(draws);
    CHECK(owned.ask(scene) == SetVerdict::found);
    scene.place(8, draws.uniform(-3, 3), 3);
    CHECK(owned.ask(scene) == SetVerdict::ambiguous);
  }
}

TEST_CASE(
    "Of two segments side by side each lies on the target that is nearest to it, whatever their numbers") {
  RivalSearch owned;
  for (const bool targets_turned : {false, true}) {
    for (const bool segments_turned : {false, true}) {
      RivalScene scene;
      testing::Draws draws(3);
      scene.segments = spiral(8, draws);
      scene.place(8, 0, 0);
      const std::uint16_t near = targets_turned ? 31 : 30, far = targets_turned ? 30 : 31;
      const std::uint16_t one = segments_turned ? 9 : 8, other = segments_turned ? 8 : 9;
      // The second target lies between both segments, nearer to the first one than to its own.
      scene.pairs.push_back({{one, near}, {0, 0, 0}, {5, 0, 0}});
      scene.pairs.push_back({{one, far}, {0, 0, 0}, {15, 0, 0}});
      scene.pairs.push_back({{other, far}, {45, 0, 0}, {15, 0, 0}});
      REQUIRE(owned.ask(scene) == SetVerdict::found);
      CHECK(owned.sets.found()[0].count == 10);
    }
  }
}

TEST_CASE("Places are refused seven times and no more, and a search that was stopped proves nothing") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  RivalSearch owned;
  RivalScene scene;
  scene.segments = spiral(10, draws);
  constexpr int kMost = mapping::SetHypotheses::kMost, kRivals = mapping::SetHypotheses::kMostRivals;
  for (int place = 0; place < kMost - 1 + kRivals; ++place) scene.place(10, draws.uniform(-3, 3), place);
  CHECK(owned.ask(scene) == SetVerdict::ambiguous);
  CHECK(owned.sets.proved());
  for (int refusal = 0; refusal < kMost - 1; ++refusal) {
    owned.sets.refuse();
    CHECK(owned.run() == SetVerdict::ambiguous);
    CHECK(owned.sets.found().size() == kRivals);
  }
  for (int refusal = 0; refusal < 3; ++refusal) {
    owned.sets.refuse();
    CHECK(owned.run() == SetVerdict::inconsistent);
    CHECK(owned.sets.found().empty());
  }
  REQUIRE(owned.sets.begin({}, scene.pairs) == Status::ok);
  std::uint64_t few = 40;
  REQUIRE_FALSE(owned.sets.run(few));
  owned.sets.stop();
  CHECK(owned.sets.verdict() == SetVerdict::undecided);
  CHECK_FALSE(owned.sets.proved());
}
