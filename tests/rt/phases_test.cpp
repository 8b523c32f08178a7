// SPDX-License-Identifier: BSD-3-Clause
// The choice of phases against a search of everything, with a load counted tick by tick.
#include "rt/phases.hpp"

#include <catch2/catch.hpp>

#include "tests/rt/schedule_support.hpp"

using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

struct TwinLoad {
  std::uint64_t waiting_ns{};
  std::uint64_t released_ns{};
  std::uint64_t busy_ns{};
};

// Tick by tick: what was left comes along, what is released is added, one tick's worth is taken off.
TwinLoad twin_worst_tick(const ScheduleTable& table, GroupSet set) {
  const std::uint64_t end = 4 * plain_hyperperiod(table) + 200;
  const auto tick_ns = static_cast<std::uint64_t>(table.base_tick_ns);
  TwinLoad load;
  std::uint64_t waiting = 0;
  std::uint64_t busy = 0;
  for (std::uint64_t tick = 0; tick < end; ++tick) {
    std::uint64_t released = 0;
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      if (((set >> i) & 1u) != 0 && table.groups[i].timing.releases_at(tick))
        released += table.groups[i].budget_ns();
    }
    waiting += released;
    load.waiting_ns = std::max(load.waiting_ns, waiting);
    load.released_ns = std::max(load.released_ns, released);
    busy += std::min(waiting, tick_ns);
    load.busy_ns = std::max(load.busy_ns, busy);
    if (waiting < tick_ns) busy = 0;
    waiting -= std::min(waiting, tick_ns);
  }
  return load;
}

std::uint64_t twin_cost(const ScheduleTable& table) {
  std::uint64_t sum = 0;
  for (const int core : cores_of(table)) sum += twin_worst_tick(table, groups_on(table, core)).waiting_ns;
  return sum;
}

// Every phase of every group but the first, whose phase moves nothing.
std::uint64_t brute_force(ScheduleTable table, std::uint32_t group = 1) {
  if (group >= table.groups.size()) return twin_cost(table);
  std::uint64_t best = ~std::uint64_t{0};
  for (std::uint32_t phase = 0; phase < table.groups[group].timing.period; ++phase) {
    table.groups[group].timing.phase = phase;
    best = std::min(best, brute_force(table, group + 1));
  }
  return best;
}

struct Ratio {
  double worst{1};
  double sum{};
  int tables{};
  int optimal{};
};

Ratio compare(std::uint32_t seed, int tables, const TableKind& kind, std::uint64_t whole) {
  std::mt19937 random(seed);
  Ratio ratio;
  while (ratio.tables < tables) {
    ScheduleTable table = random_table(random, kind);
    if (overloads(table, all_groups(table))) continue;
    for (DeclaredGroup& group : table.groups) group.timing.phase = 0;
    const std::uint64_t best = brute_force(table);
    choose_phases(table, whole);
    const std::uint64_t chosen = twin_cost(table);
    INFO(to_text(table));
    REQUIRE(chosen >= best);
    const double now = static_cast<double>(chosen) / static_cast<double>(best);
    ratio.worst = std::max(ratio.worst, now);
    ratio.sum += now;
    ratio.optimal += chosen == best ? 1 : 0;
    ++ratio.tables;
  }
  return ratio;
}

void show(const char* what, const Ratio& ratio) {
  WARN(what << ": worst tick over the best possible in " << ratio.tables << " tables: mean "
            << ratio.sum / ratio.tables << ", worst " << ratio.worst << ", optimal in " << ratio.optimal);
}

}  // namespace

TEST_CASE("the worst tick is that of a count tick by tick") {
  const std::uint32_t seed = 20261;
  std::mt19937 random(seed);
  INFO("seed " << seed);
  for (int round = 0; round < 2000; ++round) {
    TableKind kind;
    kind.cores = round % 3;
    kind.floating = round % 2 == 0;
    const ScheduleTable table = random_table(random, kind);
    for (const int core : cores_of(table)) {
      const GroupSet set = groups_on(table, core);
      if (overloads(table, set)) continue;
      INFO(to_text(table) << "core " << core);
      const TickLoad load = worst_tick(table, set);
      const TwinLoad twin = twin_worst_tick(table, set);
      REQUIRE(load.whole);
      REQUIRE(load.waiting_ns == twin.waiting_ns);
      REQUIRE(load.released_ns == twin.released_ns);
      REQUIRE(load.busy_ns == twin.busy_ns);
    }
  }
}

TEST_CASE("small tables get the best phases there are") {
  const std::uint32_t seed = 4711;
  INFO("seed " << seed);
  TableKind kind;
  kind.most_period = 6;
  for (int cores = 0; cores < 3; ++cores) {
    kind.cores = cores;
    kind.floating = cores == 2;
    const Ratio ratio = compare(seed, 60, kind, kWholeSearch);
    CHECK(ratio.worst == 1.0);
    CHECK(ratio.optimal == ratio.tables);
  }
}

TEST_CASE("tables that are too large to search whole come close to the best phases") {
  const std::uint32_t seed = 815;
  INFO("seed " << seed);
  TableKind kind;
  kind.most_period = 8;
  const Ratio any = compare(seed, 300, kind, 0);
  show("budgets by period", any);
  CHECK(any.worst <= 1.1);
  CHECK(any.sum / any.tables <= 1.01);
  kind.even = true;
  kind.least_groups = kind.most_groups = 5;
  kind.least_period = 3;
  kind.most_period = 6;
  kind.load = 2;
  const Ratio even = compare(seed, 100, kind, 0);
  show("budgets of one size", even);
  CHECK(even.worst <= 1.34);
  CHECK(even.sum / even.tables <= 1.02);
}

TEST_CASE("groups of different processors do not mind each other's ticks") {
  ScheduleTable table = table_of({declared(4, 500, 0, 0), declared(4, 500, 0, 1), declared(4, 500, 0, 0)});
  choose_phases(table);
  CHECK(table.groups[0].timing.phase == 0);
  CHECK(table.groups[1].timing.phase == 0);
  CHECK(table.groups[2].timing.phase == 1);
  CHECK(twin_cost(table) == 1'000'000);
}

TEST_CASE("a budget of several ticks counts in all of them") {
  // 3 ms from tick 0 on: the next tick that is free is the fourth.
  ScheduleTable table = table_of({declared(8, 3000), declared(8, 500), declared(8, 500)});
  choose_phases(table);
  CHECK(table.groups[0].timing.phase == 0);
  CHECK(table.groups[1].timing.phase == 3);
  CHECK(table.groups[2].timing.phase == 4);
  CHECK(worst_tick(table, all_groups(table)).busy_ns == 3'500'000);
}

TEST_CASE("phases of periods that share nothing are found in bounded time, the same way every time") {
  ScheduleTable table =
      table_of({declared(99'991, 900), declared(100'003, 800), declared(65'536, 700), declared(98'304, 600),
                declared(1, 20), declared(2, 30), declared(3, 40), declared(1'000'000, 9000)});
  ScheduleTable again = table;
  choose_phases(table);
  choose_phases(again);
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
    CHECK(table.groups[i].timing.phase == again.groups[i].timing.phase);
    CHECK(table.groups[i].timing.phase < table.groups[i].timing.period);
  }
  CHECK_FALSE(worst_tick(table, all_groups(table), 100).whole);
}
