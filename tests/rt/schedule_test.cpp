// SPDX-License-Identifier: BSD-3-Clause
// The analysis of tables against schedules that are played microsecond by microsecond, on one processor and
// on many.
#include "rt/schedule.hpp"

#include <catch2/catch.hpp>

#include "tests/rt/schedule_support.hpp"

using namespace sortie::rt;
using namespace sortie::rt::test;

namespace {

// Worst response [us] of every group, from a scheduler that looks at every microsecond: the ready groups take
// their processor, most urgent first; one that may run anywhere takes any free one. 0xffffffff: a job met the
// next release.
std::vector<std::uint32_t> play(const ScheduleTable& table, std::uint32_t processors, std::mt19937& random) {
  const std::uint32_t count = table.groups.size();
  const auto tick_us = static_cast<std::uint32_t>(table.base_tick_ns / 1000);
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return table.groups[a].timing.period < table.groups[b].timing.period;
  });
  std::vector<std::uint64_t> left(count, 0);
  std::vector<std::uint64_t> began(count, 0);
  std::vector<std::uint32_t> worst(count, 0);
  const std::uint64_t end = (3 * plain_hyperperiod(table) + 20) * tick_us;
  for (std::uint64_t now = 0; now < end; ++now) {
    for (std::uint32_t i = 0; i < count && now % tick_us == 0; ++i) {
      if (!table.groups[i].timing.releases_at(now / tick_us)) continue;
      if (left[i] != 0) worst[i] = ~0u;
      left[i] += table.groups[i].budget_ns() / 1000;
      began[i] = now;
    }
    std::vector<bool> taken(processors, false);
    for (const std::uint32_t i : order) {
      if (left[i] == 0) continue;
      std::uint32_t at = processors;
      if (table.groups[i].core >= 0) {
        at = static_cast<std::uint32_t>(table.groups[i].core);
      } else {
        const auto from = static_cast<std::uint32_t>(random() % processors);
        for (std::uint32_t k = 0; k < processors && at == processors; ++k)
          if (!taken[(from + k) % processors]) at = (from + k) % processors;
      }
      if (at == processors || taken[at]) continue;
      taken[at] = true;
      if (--left[i] == 0 && worst[i] != ~0u)
        worst[i] = std::max(worst[i], static_cast<std::uint32_t>(now + 1 - began[i]));
    }
  }
  return worst;
}

std::uint64_t us(const ResponseBound& bound) { return bound.ns / 1000; }

}  // namespace

TEST_CASE("the textbook table has the textbook responses") {
  // Three tasks of periods 7, 12, 20 and run times 3, 3, 5: responses 3, 6, 20, the last exactly at its
  // deadline.
  ScheduleTable table = table_of({declared(7, 3000), declared(12, 3000), declared(20, 5000)});
  CHECK(us(response_any_phase(table, 0)) == 3000);
  CHECK(us(response_any_phase(table, 1)) == 6000);
  CHECK(us(response_any_phase(table, 2)) == 20'000);
  CHECK(us(response_with_phases(table, 2)) == 20'000);
  CHECK(response_with_phases(table, 2).known);
  CHECK(hyperperiod(table, all_groups(table)) == 420);
  CHECK(utilisation(table, all_groups(table)) == Approx(3.0 / 7 + 3.0 / 12 + 5.0 / 20));
}

TEST_CASE("responses on one processor are those of a schedule played microsecond by microsecond") {
  const std::uint32_t seed = 77;
  std::mt19937 random(seed);
  INFO("seed " << seed);
  TableKind kind;
  kind.most_period = 8;
  kind.tick_us = 10;
  int overloaded = 0;
  int better = 0;
  for (int round = 0; round < 400; ++round) {
    const ScheduleTable table = random_table(random, kind);
    INFO(to_text(table));
    const std::vector<std::uint32_t> played = play(table, 1, random);
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      INFO("group " << i);
      const ResponseBound exact = response_with_phases(table, i);
      const ResponseBound any = response_any_phase(table, i);
      if (overloads(table, rivals(table, i) | (1u << i))) {
        ++overloaded;
        REQUIRE_FALSE(exact.known);
        REQUIRE_FALSE(any.known);
      } else if (played[i] == ~0u) {
        REQUIRE_FALSE(exact.known);
        REQUIRE(any.ns > std::uint64_t{table.groups[i].timing.period} * 10'000);
      } else {
        REQUIRE(exact.known);
        REQUIRE(us(exact) == played[i]);
        REQUIRE(any.known);
        REQUIRE(any.ns >= exact.ns);
        if (any.ns > exact.ns) ++better;
      }
    }
  }
  CHECK(overloaded > 20);
  CHECK(better > 20);
}

TEST_CASE("released together, the first jobs take exactly the response for any phase") {
  const std::uint32_t seed = 78;
  std::mt19937 random(seed);
  INFO("seed " << seed);
  TableKind kind;
  kind.most_period = 8;
  kind.tick_us = 10;
  kind.phases = false;
  for (int round = 0; round < 300; ++round) {
    const ScheduleTable table = random_table(random, kind);
    INFO(to_text(table));
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      const ResponseBound exact = response_with_phases(table, i);
      if (exact.known) REQUIRE(exact.ns == response_any_phase(table, i).ns);
    }
  }
}

TEST_CASE("no schedule on several processors is slower than what was computed, wherever free groups run") {
  const std::uint32_t seed = 79;
  std::mt19937 random(seed);
  INFO("seed " << seed);
  TableKind kind;
  kind.most_period = 8;
  kind.tick_us = 10;
  kind.cores = 2;
  kind.load = 1.2;
  int compared = 0;
  for (int round = 0; round < 400; ++round) {
    kind.floating = round % 2 == 0;
    const ScheduleTable table = random_table(random, kind);
    INFO(to_text(table));
    const std::vector<std::uint32_t> played = play(table, 2, random);
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      const ResponseBound exact = response_with_phases(table, i);
      if (!exact.known) continue;
      INFO("group " << i);
      REQUIRE(played[i] <= us(exact));
      REQUIRE(exact.ns <= response_any_phase(table, i).ns);
      // Groups that are all pinned are analysed processor by processor: exactly.
      if (!kind.floating) REQUIRE(played[i] == us(exact));
      ++compared;
    }
  }
  CHECK(compared > 400);
}

TEST_CASE("a free group joins what is pinned to different processors, and nothing else does") {
  const ScheduleTable pinned =
      table_of({declared(2, 10, 0, 0), declared(3, 10, 0, 1), declared(5, 10, 0, 0)});
  CHECK(rivals(pinned, 2) == 0b001u);
  CHECK(rivals(pinned, 1) == 0u);
  // The free one may be pushed onto processor 0 by the group on processor 1.
  const ScheduleTable free = table_of({declared(2, 10, 0, 1), declared(3, 10, 0, -1), declared(5, 10, 0, 0)});
  CHECK(rivals(free, 2) == 0b011u);
  CHECK(rivals(free, 1) == 0b001u);
  CHECK(rivals(free, 0) == 0u);
  // Equal periods: the table decides.
  const ScheduleTable ties = table_of({declared(5, 10), declared(5, 10)});
  CHECK(rivals(ties, 0) == 0u);
  CHECK(rivals(ties, 1) == 0b01u);
}

TEST_CASE("a hyperperiod longer than 2^63 ticks says so, and nothing overflows on the way") {
  ScheduleTable table = table_of({declared(4'294'967'291u, 10), declared(4'294'967'279u, 10)});
  CHECK(hyperperiod(table, all_groups(table)) == 0);  // 1.8e19
  CHECK_FALSE(response_with_phases(table, 0).known);
  CHECK(response_any_phase(table, 0).known);
  CHECK(us(response_any_phase(table, 0)) == 20);
  CHECK_FALSE(overloads(table, all_groups(table)));
  table.groups[1].timing.period = 2'147'483'648u;
  CHECK(hyperperiod(table, all_groups(table)) == 4'294'967'291ull * 2'147'483'648ull);  // 2^63 - 1.07e10
  CHECK(hyperperiod(table, 0b01u) == 4'294'967'291ull);
  CHECK(hyperperiod(table, 0u) == 1);
}

TEST_CASE("all of a processor is not too much, one nanosecond more is") {
  ScheduleTable table = table_of({declared(3, 1000), declared(3, 1000), declared(3, 1000)});
  CHECK_FALSE(overloads(table, all_groups(table)));
  CHECK(us(response_with_phases(table, 2)) == 3000);
  table.groups[0].tasks[0].budget_ns += 1;
  CHECK(overloads(table, all_groups(table)));
  CHECK_FALSE(response_with_phases(table, 2).known);
}

TEST_CASE("two periods of which neither divides the other are named") {
  CHECK_FALSE(not_harmonic(table_of({declared(1, 1), declared(100, 1), declared(10, 1)})).found);
  const OddPair pair =
      not_harmonic(table_of({declared(1, 1), declared(4, 1), declared(8, 1), declared(6, 1)}));
  CHECK(pair.found);
  CHECK(pair.a == 1);
  CHECK(pair.b == 3);
}

TEST_CASE("utilisation falls with the levels of the ladder, by criticality") {
  ScheduleTable table = table_of({declared(10, 2000)});
  static_cast<void>(table.groups[0].tasks.push_back({3'000'000, Criticality::b}));
  static_cast<void>(table.groups[0].tasks.push_back({4'000'000, Criticality::c}));
  const double expected[kLevels] = {0.9, 0.7, 0.5, 0.35, 0.2};
  for (std::uint8_t level = 0; level < kLevels; ++level)
    CHECK(utilisation(table, 1u, level) == Approx(expected[level]));
}
