// SPDX-License-Identifier: BSD-3-Clause
// Bounds of chains against tables that are played tick by tick with an event at every tick.
#include "rt/chains.hpp"

#include <catch2/catch.hpp>

#include "rt/chain_path.hpp"
#include "tests/rt/executive_rig.hpp"
#include "tests/rt/schedule_support.hpp"

using namespace sortie;
using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

constexpr std::uint64_t kTickNs = 1'000'000;

struct Output {
  std::int64_t due;
  std::int64_t newest;  // tick of the newest event it knows of, or -1
};

// Every group at every tick, as a runner would: what is due by now can be read, nothing else.
std::vector<Output> play(const ScheduleTable& table, const Chain& chain, std::int64_t end) {
  std::vector<std::vector<Output>> outputs(chain.legs.size());
  std::vector<std::vector<std::int64_t>> inputs(chain.legs.size());
  for (std::int64_t tick = 0; tick < end; ++tick) {
    for (std::uint32_t i = 0; i < chain.legs.size(); ++i) {
      const GroupTiming& timing = table.groups[chain.legs[i].group].timing;
      if (!timing.releases_at(static_cast<Tick>(tick))) continue;
      std::int64_t newest = i == 0 ? tick : -1;
      for (std::size_t k = 0; i > 0 && k < outputs[i - 1].size(); ++k) {
        if (outputs[i - 1][k].due <= tick) newest = std::max(newest, outputs[i - 1][k].newest);
      }
      inputs[i].push_back(newest);
      const std::size_t back = chain.legs[i].jobs_back;
      const std::int64_t out = inputs[i].size() > back ? inputs[i][inputs[i].size() - 1 - back] : -1;
      outputs[i].push_back({tick + timing.deadline, out});
    }
  }
  return outputs.back();
}

struct Measured {
  std::int64_t reaction{};
  std::int64_t age{};
};

Measured measure(const std::vector<Output>& outputs, std::int64_t from, std::int64_t to) {
  Measured worst;
  std::size_t k = 0;
  for (std::int64_t event = from; event < to; ++event) {
    while (k < outputs.size() && outputs[k].newest < event) ++k;
    if (k == outputs.size()) break;
    worst.reaction = std::max(worst.reaction, outputs[k].due - event);
  }
  for (const Output& output : outputs) {
    if (output.newest >= from) worst.age = std::max(worst.age, output.due - output.newest);
  }
  return worst;
}

Chain random_chain(std::mt19937& random, const ScheduleTable& table, std::uint32_t most_legs) {
  Chain chain;
  const std::uint32_t legs = draw(random, 1, most_legs);
  while (chain.legs.size() < legs) {
    const auto group = static_cast<std::uint16_t>(draw(random, 0, table.groups.size() - 1));
    if (!chain.legs.empty() && chain.legs.back().group == group) {
      if (table.groups.size() == 1) break;
      continue;
    }
    static_cast<void>(chain.legs.push_back({group, 0, draw(random, 0, 5) == 0 ? draw(random, 1, 2) : 0}));
  }
  return chain;
}

}  // namespace

TEST_CASE("reaction time and data age are those of a table played tick by tick") {
  const std::uint32_t seed = 31415;
  std::mt19937 random(seed);
  INFO("seed " << seed);
  TableKind kind;
  kind.most_period = 9;
  for (int round = 0; round < 500; ++round) {
    const ScheduleTable table = random_table(random, kind);
    const Chain chain = random_chain(random, table, 4);
    std::string text = to_text(table) + "legs";
    for (const ChainLeg& leg : chain.legs)
      text += " " + std::to_string(leg.group) + "-" + std::to_string(leg.jobs_back);
    INFO(text);
    const auto period = static_cast<std::int64_t>(plain_hyperperiod(table));
    if (period > 900) continue;
    const std::int64_t warm = 150;  // more than any path through four groups of nine ticks
    const Measured measured = measure(play(table, chain, warm + 3 * period + 300), warm, warm + 2 * period);
    const ChainBound bound = chain_bound(table, chain);
    REQUIRE(bound.exact);
    // An event at a tick may still be latched there; the bound is for one that comes just after a release.
    REQUIRE(bound.reaction_ns == static_cast<std::uint64_t>(measured.reaction + 1) * kTickNs);
    REQUIRE(bound.age_ns == static_cast<std::uint64_t>(measured.age) * kTickNs);
  }
}

TEST_CASE("a chain within one group reacts within a period and a deadline, and is as old as its deadline") {
  const ScheduleTable table = table_of({declared(10, 100, 3, -1, 4)});
  Chain chain;
  static_cast<void>(chain.legs.push_back({0, 0, 0}));
  CHECK(chain_bound(table, chain).reaction_ns == 14 * kTickNs);
  CHECK(chain_bound(table, chain).age_ns == 4 * kTickNs);
  chain.source_interval_ns = 25'000'000;
  CHECK(chain_bound(table, chain).reaction_ns == 14 * kTickNs);
  CHECK(chain_bound(table, chain).age_ns == 29 * kTickNs);
  chain.legs[0].jobs_back = 2;
  CHECK(chain_bound(table, chain).reaction_ns == 34 * kTickNs);
}

TEST_CASE(
    "where a pattern is too long to be walked the bound is taken hop by hop and is never below the exact "
    "one") {
  const std::uint32_t seed = 2718;
  std::mt19937 random(seed);
  INFO("seed " << seed);
  const ScheduleTable huge = table_of({declared(1'000'003, 100), declared(999'983, 100, 0, -1, 5)});
  Chain two;
  static_cast<void>(two.legs.push_back({0, 0, 0}));
  static_cast<void>(two.legs.push_back({1, 0, 0}));
  const ChainBound bound = chain_bound(huge, two);
  CHECK_FALSE(bound.exact);
  // Waits for a release, runs to its deadline, just misses the next group, runs to that one's deadline.
  CHECK(bound.reaction_ns == (1'000'003ull + 1'000'003 + 999'982 + 5) * kTickNs);
  CHECK(bound.age_ns == (1'000'003ull + 1'000'002 + 5) * kTickNs);
  // The same two groups made small enough to be walked meet in every way, so the worst of each hop does
  // happen.
  const ScheduleTable small = table_of({declared(7, 100), declared(5, 100, 0, -1, 2)});
  CHECK(chain_bound(small, two).exact);
  CHECK(chain_bound(small, two).reaction_ns == (7 + 7 + 4 + 2) * kTickNs);
  CHECK(chain_bound(small, two).age_ns == (7 + 6 + 2) * kTickNs);
}

TEST_CASE("a path is found by names, and what is missing is named") {
  std::vector<std::byte> memory(1 << 20);
  Arena arena(memory);
  Executive executive(arena, 1'000'000, 0);
  const GroupId fast = executive.add_group({"fast", 1, 0, -1});
  const GroupId slow = executive.add_group({"slow", 10, 0, -1});
  static_cast<void>(executive.add_stream<Sum>(fast, "A", 8, 4));
  static_cast<void>(executive.add_stream<Sum>(slow, "B", 8, 4));
  const auto nothing = [](JobContext&, Sum&) {};
  static_cast<void>(executive.add_task<Sum>(fast, "first", 10, nothing));
  auto* second = executive.add_task<Sum>(fast, "second", 10, nothing);
  static_cast<void>(executive.add_task<Sum>(slow, "third", 10, nothing));
  static_cast<void>(executive.add_input(slow, second, 16));
  REQUIRE(executive.seal() == Status::ok);
  const auto find = [&executive](std::initializer_list<const char*> names) {
    const std::vector<const char*> steps(names);
    return find_chain(executive, steps.data(), static_cast<std::uint32_t>(steps.size()));
  };
  const FoundPath whole = find({"A", "first", "second", "third"});
  REQUIRE(whole.fault == PathFault::none);
  REQUIRE(whole.chain.legs.size() == 2);
  CHECK(whole.chain.from_stream);
  CHECK(whole.chain.legs[0].group == 0);
  CHECK(whole.chain.legs[0].jobs_back == 0);
  CHECK(whole.chain.legs[1].group == 1);
  REQUIRE(whole.chain.steps.size() == 3);
  CHECK(whole.chain.steps[1].leg == 0);
  CHECK(whole.chain.steps[1].task == 1);
  CHECK_FALSE(whole.chain.steps[1].backward);
  CHECK(whole.chain.steps[2].leg == 1);
  CHECK(chain_bound(declared_table(executive), whole.chain).reaction_ns == (1 + 1 + 9 + 10) * kTickNs);

  const FoundPath backward = find({"second", "first"});
  REQUIRE(backward.fault == PathFault::none);
  CHECK_FALSE(backward.chain.from_stream);
  CHECK(backward.chain.legs[0].jobs_back == 1);
  CHECK(backward.chain.steps[1].backward);

  CHECK(find({}).fault == PathFault::no_task);
  CHECK(find({"A"}).fault == PathFault::no_task);
  CHECK(find({"A", "frist"}).fault == PathFault::unknown);
  CHECK(find({"A", "frist"}).step == 1);
  CHECK(find({"C", "first"}).fault == PathFault::unknown);
  CHECK(find({"first", "A"}).fault == PathFault::unknown);  // a stream can only begin a chain
  CHECK(find({"B", "first"}).fault == PathFault::not_consumed);
  CHECK(find({"A", "first", "third"}).fault == PathFault::not_read);  // only `second` is read
  CHECK(find({"A", "first", "third"}).step == 2);
  CHECK(find({"B", "third", "first"}).fault == PathFault::not_read);
}
