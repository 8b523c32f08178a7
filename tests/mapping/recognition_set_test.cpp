// SPDX-License-Identifier: BSD-3-Clause
// Consistent sets: beside every subset of small graphs, with planted sets in large ones, a budget at a time.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <random>
#include <vector>

#include "mapping/recognition/consistent_set.hpp"
#include "tests/mapping/registration_world.hpp"

namespace {
using namespace sortie;
using mapping::BitGraph;
using mapping::ConsistentSetRoom;

/// A graph with memory of its own, all vertices members.
struct OwnedGraph {
  std::vector<BitGraph::Word> bits, members;
  BitGraph graph;

  explicit OwnedGraph(std::uint32_t vertices)
      : bits(BitGraph::matrix_words(vertices)), members(BitGraph::words_of(vertices)), graph(vertices, bits) {
    for (std::uint32_t v = 0; v < vertices; ++v) BitGraph::put(members, v);
  }
  void connect_at_random(double density, testing::Draws& draws) {
    for (std::uint32_t a = 0; a < graph.vertices(); ++a) {
      for (std::uint32_t b = 0; b < a; ++b) {
        if (draws.uniform(0, 1) < density) graph.connect(a, b);
      }
    }
  }
  void plant(std::uint32_t size, testing::Draws& draws) {
    std::vector<std::uint32_t> clique;
    while (clique.size() < size) {
      const auto v = static_cast<std::uint32_t>(draws.uniform(0, graph.vertices()));
      if (std::find(clique.begin(), clique.end(), v) != clique.end()) continue;
      for (const std::uint32_t other : clique) graph.connect(v, other);
      clique.push_back(v);
    }
  }
};

struct OwnedSet {
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::ConsistentSet set;

  explicit OwnedSet(const ConsistentSetRoom& room) : memory(1 << 20), arena(memory), set(room, arena) {}
};

/// Every vertex or not, larger first, up to 24 vertices.
std::uint32_t largest_clique(const BitGraph& graph, std::uint32_t pool) {
  if (pool == 0) return 0;
  const auto v = static_cast<std::uint32_t>(std::countr_zero(pool));
  const std::uint32_t rest = pool & (pool - 1);
  const std::uint32_t with = 1 + largest_clique(graph, rest & static_cast<std::uint32_t>(graph.row(v)[0]));
  return std::max(with, (graph.row(v)[0] & rest) == rest ? 0 : largest_clique(graph, rest));
}

bool is_clique(const BitGraph& graph, std::span<const std::uint16_t> set) {
  for (const std::uint16_t a : set) {
    for (const std::uint16_t b : set) {
      if (a != b && !graph.adjacent(a, b)) return false;
    }
  }
  return true;
}

/// Twin of the core numbers: members that have fewer than c neighbours go, as long as there are such.
std::vector<std::uint32_t> core_numbers(const OwnedGraph& owned) {
  const BitGraph& graph = owned.graph;
  std::vector<std::uint32_t> core(graph.vertices(), 0);
  std::vector<bool> in(graph.vertices(), true);
  for (std::uint32_t c = 1; c < graph.vertices(); ++c) {
    for (bool gone = true; gone;) {
      gone = false;
      for (std::uint32_t v = 0; v < graph.vertices(); ++v) {
        std::uint32_t beside = 0;
        BitGraph::each(graph.row(v), [&](std::uint32_t u) { beside += in[u] ? 1u : 0u; });
        if (in[v] && beside < c) in[v] = false, gone = true;
      }
    }
    for (std::uint32_t v = 0; v < graph.vertices(); ++v) {
      if (in[v]) core[v] = c;
    }
  }
  return core;
}
}  // namespace

TEST_CASE("Core numbers are those of taking vertices away until none has too few neighbours") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  std::vector<std::byte> memory(1 << 16);
  rt::Arena arena(memory);
  mapping::CoreOrder order(200, arena);
  REQUIRE(arena.refused() == 0);
  for (int run = 0; run < 60; ++run) {
    OwnedGraph owned(static_cast<std::uint32_t>(draws.uniform(1, 90)));
    owned.connect_at_random(draws.uniform(0, 1), draws);
    order.begin(owned.graph, owned.members);
    for (std::uint64_t units = 3; !order.run(units); units = 3) {
    }
    const auto expected = core_numbers(owned);
    REQUIRE(order.order().size() == owned.graph.vertices());
    for (std::uint32_t i = 0; i < owned.graph.vertices(); ++i) {
      const std::uint16_t v = order.order()[i];
      CHECK(order.core(v) == expected[v]);
      CHECK(order.position(v) == i);
      if (i > 0) CHECK(order.core(v) >= order.core(order.order()[i - 1]));
      std::uint32_t behind = 0;
      BitGraph::each(owned.graph.row(v), [&](std::uint32_t u) { behind += order.position(u) > i ? 1u : 0u; });
      CHECK(behind <= order.core(v));
    }
  }
}

TEST_CASE("Of 10,000 graphs of up to 24 vertices the largest set is found and proved") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedSet owned({64, 64, 32});
  REQUIRE(owned.arena.refused() == 0);
  for (int run = 0; run < 10'000; ++run) {
    OwnedGraph g(static_cast<std::uint32_t>(draws.uniform(0, 25)));
    g.connect_at_random(draws.uniform(0, 1), draws);
    const auto least = static_cast<std::uint32_t>(draws.uniform(0, 7));
    const std::uint32_t all = g.graph.vertices() == 0 ? 0 : (1u << g.graph.vertices()) - 1;
    const std::uint32_t largest = largest_clique(g.graph, all);
    owned.set.begin(g.graph, g.members, least);
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(owned.set.run(units));
    REQUIRE(owned.set.proved());
    REQUIRE(is_clique(g.graph, owned.set.found()));
    REQUIRE(owned.set.found().size() == (largest < least ? 0 : largest));
  }
}

TEST_CASE("More units never give a smaller set, and the last one is the same whatever the budgets") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  OwnedSet once({300, 300, 64}), step({300, 300, 64});
  REQUIRE(once.arena.refused() == 0);
  for (int run = 0; run < 20; ++run) {
    OwnedGraph g(static_cast<std::uint32_t>(draws.uniform(100, 301)));
    g.connect_at_random(draws.uniform(0.02, 0.4), draws);
    g.plant(9, draws);
    once.set.begin(g.graph, g.members, 4);
    std::uint64_t all = ~std::uint64_t{0};
    REQUIRE(once.set.run(all));
    step.set.begin(g.graph, g.members, 4);
    std::size_t last = 0;
    for (bool done = false; !done;) {
      std::uint64_t units = static_cast<std::uint64_t>(draws.uniform(1, 400));
      done = step.set.run(units);
      CHECK(step.set.found().size() >= last);
      last = step.set.found().size();
      REQUIRE(is_clique(g.graph, step.set.found()));
    }
    CHECK(once.set.proved());
    CHECK(step.set.proved());
    CHECK(last >= 9);
    REQUIRE(std::equal(once.set.found().begin(), once.set.found().end(), step.set.found().begin(),
                       step.set.found().end()));
  }
}

TEST_CASE("Graphs without an edge, whole ones, and such that there is no room for") {
  OwnedSet owned({200, 40, 30});
  REQUIRE(owned.arena.refused() == 0);
  const auto run = [&](const OwnedGraph& g, std::uint32_t least) {
    owned.set.begin(g.graph, g.members, least);
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(owned.set.run(units));
    return owned.set.found().size();
  };
  OwnedGraph lonely(100), whole(30), large(35), vast(201), wide(100);
  CHECK(run(lonely, 1) == 1);
  CHECK(run(lonely, 2) == 0);
  CHECK(owned.set.proved());
  testing::Draws draws(1);
  whole.connect_at_random(1.1, draws);
  CHECK(run(whole, 2) == 30);  // as many as there is room for: there may be more
  CHECK_FALSE(owned.set.proved());
  CHECK(run(whole, 31) == 0);
  CHECK(owned.set.proved());
  large.connect_at_random(1.1, draws);
  CHECK(run(large, 2) == 30);  // the set's room
  CHECK_FALSE(owned.set.proved());
  CHECK(run(vast, 1) == 0);
  CHECK_FALSE(owned.set.proved());
  // A clique of 20, and about each of its vertices more neighbours than there is room to search.
  wide.connect_at_random(0.7, draws);
  wide.plant(20, draws);
  CHECK(run(wide, 2) >= 15);
  CHECK_FALSE(owned.set.proved());
  // Members alone count.
  for (std::uint32_t v = 0; v < 10; ++v) BitGraph::take(whole.members, v);
  CHECK(run(whole, 2) == 20);
}
