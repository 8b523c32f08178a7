// SPDX-License-Identifier: BSD-3-Clause
#include "rt/schedule.hpp"

#include <numeric>

#include "rt/release_walk.hpp"

namespace sortie::rt {

namespace {

constexpr std::uint64_t kLongest = std::uint64_t{1} << 63;

bool contains(GroupSet set, std::uint32_t group) { return ((set >> group) & 1u) != 0; }

bool may_meet(const DeclaredGroup& a, const DeclaredGroup& b) {
  return a.core == b.core || a.core < 0 || b.core < 0;
}

std::uint64_t tick_of(const ScheduleTable& table) { return static_cast<std::uint64_t>(table.base_tick_ns); }

}  // namespace

std::uint64_t hyperperiod(const ScheduleTable& table, GroupSet set) {
  std::uint64_t result = 1;
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
    if (!contains(set, i)) continue;
    const std::uint64_t period = table.groups[i].timing.period;
    const std::uint64_t factor = period / std::gcd(result, period);
    if (factor > kLongest / result) return 0;
    result *= factor;
  }
  return result;
}

OddPair not_harmonic(const ScheduleTable& table) {
  for (std::uint32_t a = 0; a < table.groups.size(); ++a) {
    for (std::uint32_t b = a + 1; b < table.groups.size(); ++b) {
      const std::uint32_t one = table.groups[a].timing.period;
      const std::uint32_t other = table.groups[b].timing.period;
      if (one % other != 0 && other % one != 0) return {true, a, b};
    }
  }
  return {};
}

bool runs_before(const ScheduleTable& table, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t one = table.groups[a].timing.period;
  const std::uint32_t other = table.groups[b].timing.period;
  return one < other || (one == other && a < b);
}

GroupSet rivals(const ScheduleTable& table, std::uint32_t group) {
  GroupSet members = GroupSet{1} << group;
  for (GroupSet before = 0; before != members;) {
    before = members;
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      if (!contains(before, i)) continue;
      for (std::uint32_t other = 0; other < table.groups.size(); ++other) {
        if (runs_before(table, other, i) && may_meet(table.groups[i], table.groups[other]))
          members |= GroupSet{1} << other;
      }
    }
  }
  return members & ~(GroupSet{1} << group);
}

double utilisation(const ScheduleTable& table, GroupSet set, std::uint8_t level) {
  double sum = 0;
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
    if (!contains(set, i)) continue;
    double work_ns = 0;
    for (const DeclaredTask& task : table.groups[i].tasks) {
      const Service service = service_at(task.criticality, level);
      const double share = service == Service::full ? 1.0 : service == Service::reduced ? 0.5 : 0.0;
      work_ns += share * static_cast<double>(task.budget_ns);
    }
    sum += work_ns /
           (static_cast<double>(table.groups[i].timing.period) * static_cast<double>(table.base_tick_ns));
  }
  return sum;
}

bool overloads(const ScheduleTable& table, GroupSet set) {
  const std::uint64_t span_ticks = hyperperiod(table, set);
  std::uint64_t given = 0;
  bool fits = span_ticks != 0 && !__builtin_mul_overflow(span_ticks, tick_of(table), &given);
  std::uint64_t asked = 0;
  for (std::uint32_t i = 0; i < table.groups.size() && fits; ++i) {
    const DeclaredGroup& group = table.groups[i];
    std::uint64_t share = 0;
    if (!contains(set, i)) continue;
    fits = !__builtin_mul_overflow(span_ticks / group.timing.period, group.budget_ns(), &share) &&
           !__builtin_add_overflow(asked, share, &asked);
  }
  return fits ? asked > given : utilisation(table, set) > 1.0 + 1e-12;
}

ResponseBound response_any_phase(const ScheduleTable& table, std::uint32_t group) {
  constexpr std::uint32_t kMostIterations = 1000;
  const GroupSet above = rivals(table, group);
  const std::uint64_t own = table.groups[group].budget_ns();
  if (overloads(table, above | (GroupSet{1} << group))) return {own, false};
  std::uint64_t response = own;
  for (std::uint32_t iteration = 0; iteration < kMostIterations; ++iteration) {
    std::uint64_t next = own;
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      if (!contains(above, i)) continue;
      const std::uint64_t period = table.groups[i].timing.period * tick_of(table);
      const std::uint64_t jobs = response == 0 ? 1 : (response - 1) / period + 1;
      std::uint64_t taken = 0;
      if (__builtin_mul_overflow(jobs, table.groups[i].budget_ns(), &taken) ||
          __builtin_add_overflow(next, taken, &next))
        return {response, false};
    }
    if (next == response) return {response, true};
    response = next;
  }
  return {response, false};
}

ResponseBound response_with_phases(const ScheduleTable& table, std::uint32_t group) {
  const GroupSet above = rivals(table, group);
  const GroupSet self = GroupSet{1} << group;
  if (overloads(table, above | self)) return {table.groups[group].budget_ns(), false};
  ReleaseWalk walk(table, above | self);
  if (walk.releases(kMostReleases) > kMostReleases) return {0, false};
  const std::uint64_t budget = table.groups[group].budget_ns();
  std::uint64_t ahead = 0;     // work of rivals that waits, whoever's: all of it comes first
  std::uint64_t left = 0;      // of the group's own job
  std::uint64_t released = 0;  // tick of that job
  std::uint64_t worst = 0;
  // Between two releases nothing new comes: first the rivals' work is done, then the group's own.
  while (walk.next()) {
    if (contains(walk.released(), group)) {
      if (left != 0) return {worst, false};
      left = budget;
      released = walk.tick();
    }
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      if (contains(walk.released() & above, i)) ahead += table.groups[i].budget_ns();
    }
    const std::uint64_t span = walk.ticks_to_next() * tick_of(table);
    const std::uint64_t first = ahead < span ? ahead : span;
    ahead -= first;
    if (left == 0) continue;
    const std::uint64_t then = left < span - first ? left : span - first;
    left -= then;
    const std::uint64_t response = (walk.tick() - released) * tick_of(table) + first + then;
    if (left == 0 && response > worst) worst = response;
  }
  return {worst, true};
}

}  // namespace sortie::rt
