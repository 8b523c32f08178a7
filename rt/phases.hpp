// SPDX-License-Identifier: BSD-3-Clause
// Phases: which tick of its period a group is released at, so that declared work piles up the least.
#pragma once

#include <cstdint>

#include "rt/schedule.hpp"

namespace sortie::rt {

/// Declared work that meets in one tick of one processor [ns].
struct TickLoad {
  std::uint64_t waiting_ns{};   ///< most work that waits just after releases, with what was left over
  std::uint64_t released_ns{};  ///< most work that is released in one tick
  std::uint64_t busy_ns{};      ///< longest time without a pause, from the release that begins it
  std::uint64_t met_ns{};       ///< sum over a hyperperiod's releases of what waits then; 0 if not whole
  bool whole{true};             ///< false: only the first releases of a very long hyperperiod were looked at
};

/// The worst tick of `set` on one processor with the phases as they are. Looks at all releases through the
/// last phase and two hyperperiods, or the first `most_visits` ticks with any. Groups of every tick are free.
TickLoad worst_tick(const ScheduleTable& table, GroupSet set, std::uint32_t most_visits = kMostReleases);

/// The groups that can load processor `core`: those pinned to it and those that may run anywhere.
GroupSet groups_on(const ScheduleTable& table, int core);

/// The processors that a table names, lowest first; -1 alone when it names none.
FixedVector<int, kMaxGroups> cores_of(const ScheduleTable& table);

/// Visits up to which a table is searched whole.
inline constexpr std::uint64_t kWholeSearch = 1u << 18;

/// Chooses the phase of every group. What is made small is, first, the sum over processors of the work that
/// waits in their worst tick, second, of the work that releases meet on average. Ties go to earlier phases.
///
/// Only declared numbers enter, by integer arithmetic, so a table has the same phases on every machine. Of a
/// group's phases only those are tried that differ in how it meets the others. Tables with at most `whole`
/// visits (releases times combinations) are searched whole: no choice is better. For others groups are placed
/// one by one, most budget first, then each is moved to where it loads least until nothing improves (tests
/// compare this with a search of everything). Set-up only: up to some 10 ms.
void choose_phases(ScheduleTable& table, std::uint64_t whole = kWholeSearch);

}  // namespace sortie::rt
