// SPDX-License-Identifier: BSD-3-Clause
// Consistent correspondences: the exact test beside another one, the sweep beside all pairs one by one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "mapping/recognition/consistency_sweep.hpp"
#include "tests/mapping/registration_world.hpp"

namespace {
using namespace sortie;
using mapping::ConsistencyGates;
using mapping::PlaceCm;
using mapping::SweptPair;

/// |sqrt a - sqrt b| <= eps, with S = a + b - eps^2: S <= 0 or S^2 <= 4 a b. All below 2^64 where b is at
/// most 2^31.
bool within(std::uint64_t a, std::uint64_t b, std::uint64_t eps) {
  if (b > 1u << 31) return false;
  if (a + b <= eps * eps) return true;
  const std::uint64_t s = a + b - eps * eps;
  return s * s <= 4 * a * b;
}

std::uint64_t square(std::int64_t v) { return static_cast<std::uint64_t>(v * v); }

/// Two correspondences by the letter of the rule, by one gate.
bool consistent(const ConsistencyGates& gates, std::uint32_t gate, const SweptPair& a, const SweptPair& b) {
  if (a.pair.segment == b.pair.segment || a.pair.target == b.pair.target) return false;
  const auto apart = [](std::int32_t from, std::int32_t to) { return std::int64_t{to} - from; };
  const std::int64_t l[3] = {apart(a.segment.x, b.segment.x), apart(a.segment.y, b.segment.y),
                             apart(a.segment.z, b.segment.z)};
  const std::int64_t t[3] = {apart(a.target.x, b.target.x), apart(a.target.y, b.target.y),
                             apart(a.target.z, b.target.z)};
  const auto is_wide = [](std::int64_t d) { return d > 1'000'000 || d < -1'000'000; };  // 10 km
  if (is_wide(l[0]) || is_wide(l[1]) || is_wide(t[0]) || is_wide(t[1])) return false;
  if (!gates.gravity && (is_wide(l[2]) || is_wide(t[2]))) return false;
  const std::uint64_t flat = square(l[0]) + square(l[1]), flat_target = square(t[0]) + square(t[1]);
  const auto eps = static_cast<std::uint64_t>(gates.eps_cm[gate]);
  constexpr std::uint64_t kMost = 20'000ull * 20'000ull;
  if (!gates.gravity) {
    return flat + square(l[2]) <= kMost && within(flat + square(l[2]), flat_target + square(t[2]), eps);
  }
  const double room =
      gates.eps_cm[gate] + 1.0 + std::sqrt(static_cast<double>(flat)) * (1e-3 * gates.tilt_permille);
  return flat <= kMost && within(flat, flat_target, eps) &&
         std::fabs(static_cast<double>(t[2] - l[2])) <= room;
}

struct OwnedSweep {
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::ConsistencySweep sweep;

  explicit OwnedSweep(std::uint32_t most)
      : memory(std::size_t{most} * (most / 2 + 400) + 8'192), arena(memory), sweep(most, arena) {}
};

/// A local map of segments, and a known map in which some of them stand, turned and moved.
std::vector<SweptPair> correspondences(testing::Draws& draws, int segments, int each, double wide_cm,
                                       double map_cm) {
  const auto whole = [](double v) { return static_cast<std::int32_t>(std::floor(v)); };
  std::vector<PlaceCm> local, targets;
  const double yaw = draws.uniform(-3, 3), c = std::cos(yaw), s = std::sin(yaw);
  const double at_x = draws.uniform(-map_cm, map_cm), at_y = draws.uniform(-map_cm, map_cm);
  for (int i = 0; i < segments; ++i) {
    local.push_back({whole(draws.uniform(-wide_cm, wide_cm)), whole(draws.uniform(-wide_cm, wide_cm)),
                     whole(draws.uniform(-150, 400))});
    // Two stand in one place, and look like one target.
    if (i == 1) local[1] = {local[0].x + 3, local[0].y, local[0].z};
    const PlaceCm& p = local.back();
    targets.push_back({whole(at_x + c * p.x - s * p.y + draws.uniform(-30, 30)),
                       whole(at_y + s * p.x + c * p.y + draws.uniform(-30, 30)),
                       p.z + 700 + whole(draws.uniform(-40, 40))});
  }
  while (targets.size() < 3u * static_cast<unsigned>(segments)) {
    targets.push_back({whole(draws.uniform(-map_cm, map_cm)), whole(draws.uniform(-map_cm, map_cm)),
                       whole(draws.uniform(-150, 1200))});
  }
  std::vector<SweptPair> pairs;
  for (int i = 0; i < segments; ++i) {
    for (int k = 0; k < each; ++k) {
      const auto n = static_cast<double>(targets.size());
      auto t = static_cast<std::uint16_t>(i);
      if (k > 0) t = i == 1 && k == 1 ? std::uint16_t{0} : static_cast<std::uint16_t>(draws.uniform(0, n));
      const mapping::Correspondence pair{static_cast<std::uint16_t>(i), t};
      const auto is_there = [&](const SweptPair& p) { return p.pair == pair; };
      if (std::any_of(pairs.begin(), pairs.end(), is_there)) continue;
      pairs.push_back({pair, local[static_cast<std::size_t>(i)], targets[t]});
    }
  }
  for (std::size_t i = pairs.size(); i > 1; --i) {
    std::swap(pairs[i - 1], pairs[static_cast<std::size_t>(draws.uniform(0, static_cast<double>(i)))]);
  }
  return pairs;
}

/// Every bit of the graphs beside the rule.
int disagreements(const mapping::ConsistencySweep& sweep, const ConsistencyGates& gates,
                  const std::vector<SweptPair>& pairs, int& edges) {
  int off = 0;
  const auto count = static_cast<std::uint32_t>(pairs.size());
  for (std::uint32_t g = 0; g < ConsistencyGates::kCount; ++g) {
    const auto graph = sweep.graph(g);
    REQUIRE(graph.vertices() == count);
    for (std::uint32_t a = 0; a < count; ++a) {
      for (std::uint32_t b = 0; b < count; ++b) {
        const bool expected = a != b && consistent(gates, g, pairs[sweep.number(a)], pairs[sweep.number(b)]);
        if (graph.adjacent(a, b) != expected) ++off;
        if (expected) ++edges;
      }
      for (std::uint32_t b = count; b < 64 * graph.words(); ++b) {
        if (graph.adjacent(a, b)) ++off;
      }
    }
  }
  return off;
}

bool run_whole(mapping::ConsistencySweep& sweep) {
  std::uint64_t units = ~std::uint64_t{0};
  return sweep.run(units);
}
}  // namespace

TEST_CASE("The exact test is exact at its edges") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  int decided = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto eps = static_cast<std::int32_t>(draws.uniform(0, i % 2 == 0 ? 60 : 501));
    const ConsistencyGates gates{{eps, eps, eps}, 9, false};
    const double wide = i % 5 == 0 ? 20.0 : 11'000.0;
    const auto whole = [&](double most) {
      return static_cast<std::int32_t>(std::floor(draws.uniform(-most, most)));
    };
    SweptPair a{}, b{{1, 1}, {whole(wide), whole(wide), whole(wide)}, {}};
    const double d = std::sqrt(double(b.segment.x) * b.segment.x + double(b.segment.y) * b.segment.y +
                               double(b.segment.z) * b.segment.z);
    // Along a line near the edge, so that whole squares fall on both sides of it and next to it.
    const double at = d + (i % 3 == 0 ? -1.0 : 1.0) * eps;
    b.target = {static_cast<std::int32_t>(at + draws.uniform(-2, 2)), whole(30), whole(30)};
    const bool expected = consistent(gates, 0, a, b);
    REQUIRE((mapping::gates_passed(gates, a, b) == 3) == expected);
    decided += expected ? 1 : 0;
  }
  CHECK(decided > 20'000);
  CHECK(decided < 180'000);
}

TEST_CASE("The sweep finds the pairs that the rule finds one by one") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedSweep owned(700);
  REQUIRE(owned.arena.refused() == 0);
  int edges = 0;
  for (int run = 0; run < 24; ++run) {
    INFO("run " << run);
    // Small and wide maps; one segment with many targets, many with one; maps wider than 16 bits of cm.
    const int segments = run % 4 == 0 ? 3 : (run % 4 == 1 ? 300 : 40), each = run % 4 == 1 ? 2 : 16;
    const double map_cm = run % 3 == 0 ? 3'000 : (run % 3 == 1 ? 40'000 : 900'000);
    const auto pairs = correspondences(draws, segments, each, run % 5 == 4 ? 13'000 : 2'500, map_cm);
    const std::int32_t eps = run % 7 == 6 ? 0 : static_cast<std::int32_t>(draws.uniform(5, 90));
    const ConsistencyGates gates{
        {eps / 2, eps, 2 * eps}, static_cast<std::int32_t>(draws.uniform(0, 40)), run % 2 == 0};
    REQUIRE(owned.sweep.begin(gates, pairs) == Status::ok);
    REQUIRE(run_whole(owned.sweep));
    CHECK(disagreements(owned.sweep, gates, pairs, edges) == 0);
  }
  CHECK(edges > 10'000);
}

TEST_CASE("Places far away, and all in one place, are swept alike") {
  OwnedSweep owned(200);
  int edges = 0;
  for (const std::int32_t off : {0, 32'768, 65'536, 16'777'216, 16'777'217, 500'000'000 - 400'000}) {
    for (const bool gravity : {true, false}) {
      for (const bool local_too : {false, true}) {
        std::vector<SweptPair> pairs;
        for (int i = 0; i < 60; ++i) {
          // Every second one is `off` away, where single precision has no room for a centimetre.
          const std::int32_t far = i % 2 == 0 ? 0 : off, z = 10 * (i % 7);
          const auto n = static_cast<std::uint16_t>(i);
          const PlaceCm segment{50 * i + (local_too ? far : 0), 3 * i, z};
          pairs.push_back({{n, n}, segment, {50 * i + far, 3 * i, z + 100}});
          pairs.push_back({{n, static_cast<std::uint16_t>(100 + n)}, segment, {0, 0, far}});
        }
        const ConsistencyGates gates{{20, 40, 80}, 9, gravity};
        REQUIRE(owned.sweep.begin(gates, pairs) == Status::ok);
        REQUIRE(run_whole(owned.sweep));
        INFO("off " << off << " gravity " << gravity << " local " << local_too);
        CHECK(disagreements(owned.sweep, gates, pairs, edges) == 0);
      }
    }
  }
  CHECK(edges > 0);
}

TEST_CASE("A target beside others that are as far apart as single precision goes is swept as the rule says") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedSweep owned(200);
  const auto about = [&](double least, double most) {
    return static_cast<std::int32_t>(std::floor(draws.uniform(least, most)));
  };
  constexpr std::int32_t kEdge = 1 << 24;
  int edges = 0;
  for (int run = 0; run < 30; ++run) {
    std::vector<SweptPair> pairs;
    for (std::uint16_t i = 0; i < 128; ++i) {
      // In the order of tiles the first 64 come before the others, of which the last one stands far away.
      PlaceCm target{kEdge + about(1, 400), kEdge - about(1, 500), about(0, 300)};
      if (i >= 64) target = {kEdge - about(1, 300), kEdge + about(0, 500), about(0, 300)};
      if (i == 127) target = {3, kEdge + 10, 0};
      PlaceCm segment{target.x - kEdge + about(-45, 46), target.y - kEdge + about(-45, 46),
                      target.z + about(-30, 31)};
      if (i == 127) segment = {};
      pairs.push_back({{i, i}, segment, target});
    }
    const ConsistencyGates gates{{10, 20, 40}, 9, run % 2 == 0};
    REQUIRE(owned.sweep.begin(gates, pairs) == Status::ok);
    REQUIRE(run_whole(owned.sweep));
    CHECK(disagreements(owned.sweep, gates, pairs, edges) == 0);
  }
  CHECK(edges > 0);
}

TEST_CASE("A sweep in small budgets is the same sweep, and what it cannot take it refuses") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedSweep owned(400), whole(400);
  const auto pairs = correspondences(draws, 30, 12, 2'500, 4'000);
  REQUIRE(whole.sweep.begin({}, pairs) == Status::ok);
  REQUIRE(run_whole(whole.sweep));
  REQUIRE(owned.sweep.begin({}, pairs) == Status::ok);
  int steps = 0;
  for (std::uint64_t units = 7; !owned.sweep.run(units); units = 7) REQUIRE(++steps < 100'000);
  CHECK(steps > 100);
  for (std::uint32_t g = 0; g < ConsistencyGates::kCount; ++g) {
    for (std::uint32_t v = 0; v < whole.sweep.graph(g).vertices(); ++v) {
      const auto a = whole.sweep.graph(g).row(v), b = owned.sweep.graph(g).row(v);
      REQUIRE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    }
  }
  const auto refused = [&](const ConsistencyGates& gates) {
    CHECK(owned.sweep.begin(gates, pairs) == Status::out_of_range);
    CHECK(owned.sweep.graph(0).vertices() == 0);
  };
  refused({{-1, 40, 80}, 9, true});
  refused({{50, 40, 80}, 9, true});
  refused({{20, 90, 80}, 9, true});
  refused({{20, 40, 501}, 9, true});
  refused({{20, 40, 80}, 501, true});
  refused({{20, 40, 80}, -1, true});
  std::vector<SweptPair> beyond(1);
  beyond[0].target.z = 500'000'001;
  CHECK(owned.sweep.begin({}, beyond) == Status::out_of_range);
  CHECK(owned.sweep.begin({}, std::vector<SweptPair>(401)) == Status::full);
  CHECK(owned.sweep.begin({}, {}) == Status::ok);
  CHECK(run_whole(owned.sweep));
  CHECK(owned.sweep.graph(2).vertices() == 0);
}
