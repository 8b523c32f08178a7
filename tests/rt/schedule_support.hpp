// SPDX-License-Identifier: BSD-3-Clause
// Random tables, and a twin of the analysis that goes tick by tick and microsecond by microsecond.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "rt/schedule.hpp"

namespace sortie::rt::test {

/// A group of one task.
inline DeclaredGroup declared(std::uint32_t period, std::uint64_t budget_us, std::uint32_t phase = 0,
                              int core = -1, std::uint32_t deadline = 0) {
  DeclaredGroup group;
  group.timing = {period, phase, deadline == 0 ? period : deadline};
  group.core = core;
  static_cast<void>(group.tasks.push_back({budget_us * 1000, Criticality::a}));
  return group;
}

inline ScheduleTable table_of(std::initializer_list<DeclaredGroup> groups) {
  ScheduleTable table;
  for (const DeclaredGroup& group : groups) static_cast<void>(table.groups.push_back(group));
  return table;
}

/// A uniform whole number of low..high, the same on every platform.
inline std::uint32_t draw(std::mt19937& random, std::uint32_t low, std::uint32_t high) {
  return low + static_cast<std::uint32_t>(random() % (high - low + 1));
}

/// What a random table may be made of.
struct TableKind {
  std::uint32_t least_groups{1};
  std::uint32_t most_groups{4};
  std::uint32_t least_period{1};
  std::uint32_t most_period{12};
  std::uint32_t tick_us{1000};
  double load{0.9};   ///< budgets are drawn so that the table asks for about this much
  bool even{false};   ///< budgets of nearly equal size, whatever the period
  bool phases{true};  ///< random ones; otherwise 0
  int cores{0};       ///< 0: none named; otherwise each group gets one of these, or -1 if `floating`
  bool floating{false};
};

inline ScheduleTable random_table(std::mt19937& random, const TableKind& kind) {
  ScheduleTable table;
  table.base_tick_ns = Nanoseconds{1000} * kind.tick_us;
  const std::uint32_t count = draw(random, kind.least_groups, kind.most_groups);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t period = draw(random, kind.least_period, kind.most_period);
    const double ticks = kind.even ? 1.0 : period;
    const auto most_us = static_cast<std::uint32_t>(2.0 * kind.tick_us * kind.load * ticks / count) + 1;
    const std::uint32_t budget_us = draw(random, kind.even ? most_us / 2 : 1, most_us);
    int core = -1;
    if (kind.cores > 0) core = static_cast<int>(draw(random, 0, static_cast<std::uint32_t>(kind.cores) - 1));
    if (kind.floating && draw(random, 0, 2) == 0) core = -1;
    static_cast<void>(table.groups.push_back(declared(
        period, budget_us, kind.phases ? draw(random, 0, period - 1) : 0, core, draw(random, 1, period))));
  }
  return table;
}

inline std::string to_text(const ScheduleTable& table) {
  std::string text;
  for (const DeclaredGroup& group : table.groups) {
    text += "{T " + std::to_string(group.timing.period) + " D " + std::to_string(group.timing.deadline) +
            " O " + std::to_string(group.timing.phase) + " C " + std::to_string(group.budget_ns() / 1000) +
            " us core " + std::to_string(group.core) + "} ";
  }
  return text;
}

/// Least common multiple of all periods, the plain way.
inline std::uint64_t plain_hyperperiod(const ScheduleTable& table) {
  std::uint64_t result = 1;
  for (const DeclaredGroup& group : table.groups)
    result = std::lcm(result, std::uint64_t{group.timing.period});
  return result;
}

}  // namespace sortie::rt::test
