// SPDX-License-Identifier: BSD-3-Clause
#include "rt/chains.hpp"

#include "rt/floor_divide.hpp"

namespace sortie::rt {

namespace {

// Jobs are counted from long before tick 0 here: the pattern is the same, and nothing needs a beginning.
using Job = std::int64_t;

std::int64_t release(const GroupTiming& timing, Job job) {
  return static_cast<std::int64_t>(timing.phase) + job * static_cast<std::int64_t>(timing.period);
}
std::int64_t due(const GroupTiming& timing, Job job) {
  return release(timing, job) + static_cast<std::int64_t>(timing.deadline);
}
// First job released at or after `tick`; newest job due at or before it.
Job first_from(const GroupTiming& timing, std::int64_t tick) {
  return floor_divide(tick - timing.phase + timing.period - 1, timing.period);
}
Job newest_due(const GroupTiming& timing, std::int64_t tick) {
  return floor_divide(tick - timing.phase - timing.deadline, timing.period);
}

// When the first output that knows of what job `job` of the first group has latched becomes visible.
std::int64_t visible_from(const ScheduleTable& table, const Chain& chain, Job job) {
  std::int64_t tick = 0;
  for (std::uint32_t i = 0; i < chain.legs.size(); ++i) {
    const GroupTiming& timing = table.groups[chain.legs[i].group].timing;
    const Job in = i == 0 ? job : first_from(timing, tick);
    tick = due(timing, in + chain.legs[i].jobs_back);
  }
  return tick;
}

// When the first group latched the newest that job `job` of the last group knows of.
std::int64_t latched_for(const ScheduleTable& table, const Chain& chain, Job job) {
  Job out = job;
  for (std::uint32_t i = chain.legs.size() - 1;; --i) {
    const Job in = out - static_cast<Job>(chain.legs[i].jobs_back);
    const std::int64_t tick = release(table.groups[chain.legs[i].group].timing, in);
    if (i == 0) return tick;
    out = newest_due(table.groups[chain.legs[i - 1].group].timing, tick);
  }
}

std::uint64_t to_ns(const ScheduleTable& table, std::int64_t ticks) {
  return static_cast<std::uint64_t>(ticks) * static_cast<std::uint64_t>(table.base_tick_ns);
}

// Every hop at its worst. A value that has just become visible waits up to a period of its reader less a
// tick; the value that a reader finds became visible up to a period of its writer less a tick before.
ChainBound hop_by_hop(const ScheduleTable& table, const Chain& chain) {
  std::int64_t reaction = table.groups[chain.legs[0].group].timing.period;
  std::int64_t age = 0;
  for (std::uint32_t i = 0; i < chain.legs.size(); ++i) {
    const GroupTiming& timing = table.groups[chain.legs[i].group].timing;
    const std::int64_t stay =
        timing.deadline + static_cast<std::int64_t>(chain.legs[i].jobs_back) * timing.period;
    reaction += stay + (i == 0 ? 0 : std::int64_t{timing.period} - 1);
    age += stay + (i + 1 == chain.legs.size() ? 0 : std::int64_t{timing.period} - 1);
  }
  return {to_ns(table, reaction), to_ns(table, age), false};
}

}  // namespace

ChainBound chain_bound(const ScheduleTable& table, const Chain& chain) {
  GroupSet members = 0;
  for (const ChainLeg& leg : chain.legs) members |= GroupSet{1} << leg.group;
  const std::uint64_t repeats = hyperperiod(table, members);
  const GroupTiming& first = table.groups[chain.legs[0].group].timing;
  const GroupTiming& last = table.groups[chain.legs.back().group].timing;
  ChainBound bound;
  if (repeats == 0 || repeats / first.period > kMostReleases || repeats / last.period > kMostReleases) {
    bound = hop_by_hop(table, chain);
  } else {
    std::int64_t reaction = 0;
    for (Job job = 0; job < static_cast<Job>(repeats / first.period); ++job) {
      const std::int64_t took = visible_from(table, chain, job) - release(first, job - 1);
      reaction = took > reaction ? took : reaction;
    }
    std::int64_t age = 0;
    for (Job job = 0; job < static_cast<Job>(repeats / last.period); ++job) {
      const std::int64_t old = due(last, job) - latched_for(table, chain, job);
      age = old > age ? old : age;
    }
    bound = {to_ns(table, reaction), to_ns(table, age), true};
  }
  bound.age_ns += static_cast<std::uint64_t>(chain.source_interval_ns);
  return bound;
}

}  // namespace sortie::rt
