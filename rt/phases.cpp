// SPDX-License-Identifier: BSD-3-Clause
#include "rt/phases.hpp"

#include <numeric>

#include "rt/release_walk.hpp"

namespace sortie::rt {

namespace {

// Visits that one choice may cost, and what is looked at for each candidate at least and at most.
constexpr std::uint64_t kVisitsPerChoice = 1u << 21;
constexpr std::uint64_t kLeastVisits = 512;
constexpr std::uint64_t kMostVisits = 16'384;
constexpr std::uint64_t kMostCandidates = kVisitsPerChoice / kLeastVisits;
constexpr int kMostRounds = 8;

constexpr GroupSet bit(std::uint32_t group) { return GroupSet{1} << group; }

// What the chooser makes small, the first member first.
struct Cost {
  std::uint64_t waiting{};
  std::uint64_t met{};
  bool operator<(const Cost& other) const {
    return waiting < other.waiting || (waiting == other.waiting && met < other.met);
  }
};

Cost cost_of(const ScheduleTable& table, GroupSet set, std::uint32_t visits) {
  Cost cost;
  for (const int core : cores_of(table)) {
    const TickLoad load = worst_tick(table, groups_on(table, core) & set, visits);
    cost.waiting += load.waiting_ns;
    cost.met += load.met_ns;
  }
  return cost;
}

// Phases of `group` that differ in how it meets the groups of `set`: gcd(its period, lcm(theirs)), by a form
// that cannot overflow. Groups on other processors count only where one that may run anywhere ties all.
std::uint64_t alignments(const ScheduleTable& table, std::uint32_t group, GroupSet set) {
  const std::uint64_t period = table.groups[group].timing.period;
  bool tied = false;
  for (const DeclaredGroup& other : table.groups) tied = tied || other.core < 0;
  std::uint64_t result = 1;
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
    const bool meets = tied || table.groups[i].core == table.groups[group].core;
    if ((set & bit(i) & ~bit(group)) != 0 && meets)
      result = std::lcm(result, std::gcd(period, std::uint64_t{table.groups[i].timing.period}));
  }
  return result;
}

// Most budget first: what is hardest to place has the free choice.
FixedVector<std::uint32_t, kMaxGroups> placing_order(const ScheduleTable& table) {
  FixedVector<std::uint32_t, kMaxGroups> order;
  GroupSet placed = 0;
  for (std::uint32_t n = 0; n < table.groups.size(); ++n) {
    std::uint32_t best = kMaxGroups;
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      if ((placed & bit(i)) != 0) continue;
      if (best == kMaxGroups || table.groups[i].budget_ns() > table.groups[best].budget_ns()) best = i;
    }
    placed |= bit(best);
    static_cast<void>(order.push_back(best));  // as many as there are groups
  }
  return order;
}

// Moves one group to the phase where the groups of `set` load each other least, if that is any better.
bool place(ScheduleTable& table, std::uint32_t group, GroupSet set, bool anywhere) {
  const std::uint64_t ways = alignments(table, group, set);
  const std::uint64_t stride = (ways + kMostCandidates - 1) / kMostCandidates;
  const std::uint64_t candidates = (ways + stride - 1) / stride;
  const std::uint64_t share = kVisitsPerChoice / candidates;
  const auto visits = static_cast<std::uint32_t>(share < kMostVisits ? share : kMostVisits);
  std::uint32_t& phase = table.groups[group].timing.phase;
  std::uint32_t best_phase = phase;
  Cost best = anywhere ? Cost{~std::uint64_t{0}, ~std::uint64_t{0}} : cost_of(table, set, visits);
  const std::uint32_t before = phase;
  for (std::uint64_t candidate = 0; candidate < ways; candidate += stride) {
    phase = static_cast<std::uint32_t>(candidate);
    const Cost cost = cost_of(table, set, visits);
    if (!(cost < best)) continue;
    best = cost;
    best_phase = phase;
  }
  phase = best_phase;
  return phase != before;
}

// Tries every combination, like an odometer over the groups in table order; the first of the best stays.
// False, with no phases chosen, when that would take more than `most` visits.
bool search_whole(ScheduleTable& table, std::uint64_t most) {
  std::uint64_t ways[kMaxGroups]{};
  std::uint64_t combinations = 1;
  std::uint64_t releases = 0;
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
    ways[i] = alignments(table, i, bit(i) - 1u);
    if (ways[i] > most / combinations) return false;
    combinations *= ways[i];
    table.groups[i].timing.phase = static_cast<std::uint32_t>(ways[i] - 1);  // the longest walk there is
  }
  for (const int core : cores_of(table)) {
    GroupSet moving = groups_on(table, core);
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      if (table.groups[i].timing.period == 1) moving &= ~bit(i);
    }
    releases += ReleaseWalk(table, moving).releases(most / combinations);
  }
  if (releases > most / combinations) return false;
  std::uint32_t best_phase[kMaxGroups]{};
  Cost best{~std::uint64_t{0}, ~std::uint64_t{0}};
  for (std::uint64_t combination = 0; combination < combinations; ++combination) {
    std::uint64_t rest = combination;
    for (std::uint32_t n = table.groups.size(); n-- > 0; rest /= ways[n])
      table.groups[n].timing.phase = static_cast<std::uint32_t>(rest % ways[n]);
    const Cost cost = cost_of(table, all_groups(table), static_cast<std::uint32_t>(releases));
    if (!(cost < best)) continue;
    best = cost;
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) best_phase[i] = table.groups[i].timing.phase;
  }
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) table.groups[i].timing.phase = best_phase[i];
  return true;
}

}  // namespace

GroupSet groups_on(const ScheduleTable& table, int core) {
  GroupSet set = 0;
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
    if (table.groups[i].core < 0 || table.groups[i].core == core) set |= bit(i);
  }
  return set;
}

FixedVector<int, kMaxGroups> cores_of(const ScheduleTable& table) {
  FixedVector<int, kMaxGroups> cores;
  for (int above = -1;;) {
    int next = -1;
    for (const DeclaredGroup& group : table.groups) {
      if (group.core > above && (next < 0 || group.core < next)) next = group.core;
    }
    if (next < 0) break;
    static_cast<void>(cores.push_back(next));  // at most one a group
    above = next;
  }
  if (cores.empty()) static_cast<void>(cores.push_back(-1));
  return cores;
}

TickLoad worst_tick(const ScheduleTable& table, GroupSet set, std::uint32_t most_visits) {
  // A group of every tick takes its share of each: what is left is all that the others have.
  std::uint64_t steady = 0;
  GroupSet moving = set;
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
    if ((set & bit(i)) == 0 || table.groups[i].timing.period != 1) continue;
    steady += table.groups[i].budget_ns();
    moving &= ~bit(i);
  }
  const auto tick_ns = static_cast<std::uint64_t>(table.base_tick_ns);
  const std::uint64_t room = steady < tick_ns ? tick_ns - steady : 0;
  TickLoad load{steady, steady, steady, 0, true};
  ReleaseWalk walk(table, moving);
  std::uint64_t waiting = 0;
  std::uint64_t began = 0;
  bool paused = true;
  for (std::uint32_t visits = 0; walk.next(); ++visits) {
    if (visits == most_visits) {
      load.whole = false;
      break;
    }
    std::uint64_t released = 0;
    std::uint64_t jobs = 0;
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      if ((walk.released() & bit(i)) == 0) continue;
      released += table.groups[i].budget_ns();
      ++jobs;
    }
    if (paused) began = walk.tick();
    waiting += released;
    if (waiting + steady > load.waiting_ns) load.waiting_ns = waiting + steady;
    if (released + steady > load.released_ns) load.released_ns = released + steady;
    if (walk.in_last_hyperperiod()) load.met_ns += jobs * waiting;
    // Whole ticks with only `room` for this work, and the last one in part.
    const std::uint64_t ticks = walk.ticks_to_next();
    const std::uint64_t needed = room == 0 ? ticks : waiting / room;
    const std::uint64_t full = needed < ticks ? needed : ticks;
    waiting -= full * room < waiting ? full * room : waiting;
    const std::uint64_t busy = (walk.tick() - began + full) * tick_ns + (full < ticks ? waiting + steady : 0);
    if (busy > load.busy_ns) load.busy_ns = busy;
    paused = full < ticks;
    if (paused) waiting = 0;
  }
  if (!load.whole) load.met_ns = 0;
  return load;
}

void choose_phases(ScheduleTable& table, std::uint64_t whole) {
  if (search_whole(table, whole)) return;
  for (DeclaredGroup& group : table.groups) group.timing.phase = 0;
  const FixedVector<std::uint32_t, kMaxGroups> order = placing_order(table);
  GroupSet placed = 0;
  for (const std::uint32_t group : order) {
    placed |= bit(group);
    static_cast<void>(place(table, group, placed, true));
  }
  for (int round = 0; round < kMostRounds; ++round) {
    bool moved = false;
    for (const std::uint32_t group : order) moved = place(table, group, placed, false) || moved;
    if (!moved) return;
  }
}

}  // namespace sortie::rt
