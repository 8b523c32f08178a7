// SPDX-License-Identifier: BSD-3-Clause
// The declared table of groups, and what follows from it before anything runs: hyperperiod, utilisation, and
// the worst response of every group under the priorities of the live runner.
#pragma once

#include <cstdint>

#include "rt/fixed_vector.hpp"
#include "rt/job_record.hpp"
#include "rt/ladder.hpp"
#include "rt/let_channel.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// What a task declares: its worst run time, and whether it gives way under overload.
struct DeclaredTask {
  std::uint64_t budget_ns{};
  Criticality criticality{Criticality::a};
};

/// A group as it is declared. Times in base ticks; 1 <= deadline <= period.
struct DeclaredGroup {
  GroupTiming timing;
  int core{-1};  ///< processor of its worker; -1: any of them
  FixedVector<DeclaredTask, kMaxTasksPerGroup> tasks;

  /// Worst run time of one job: the sum of the tasks' budgets.
  constexpr std::uint64_t budget_ns() const {
    std::uint64_t sum = 0;
    for (const DeclaredTask& task : tasks) sum += task.budget_ns;
    return sum;
  }
};

/// The whole table, in the order that settles ties.
struct ScheduleTable {
  Nanoseconds base_tick_ns{1'000'000};
  FixedVector<DeclaredGroup, kMaxGroups> groups;
};

/// Groups of a table, one bit each.
using GroupSet = std::uint32_t;
static_assert(kMaxGroups <= 32, "a set of groups has 32 bits");

/// All groups of a table.
constexpr GroupSet all_groups(const ScheduleTable& table) {
  return static_cast<GroupSet>((std::uint64_t{1} << table.groups.size()) - 1u);
}

/// Ticks after which the pattern of releases of `set` repeats: the least common multiple of its periods. 0
/// when that is longer than 2^63 ticks; 1 for no groups. Exact.
std::uint64_t hyperperiod(const ScheduleTable& table, GroupSet set);

/// Two groups of which neither period divides the other. Such a table is not harmonic: its groups meet in
/// ever different ways, and responses jitter.
struct OddPair {
  bool found{};
  std::uint32_t a{};
  std::uint32_t b{};
};
/// The first such pair in table order, or none.
OddPair not_harmonic(const ScheduleTable& table);

/// Rate-monotonic: true if `a` runs before `b` when both are ready. The shorter period, then the table.
bool runs_before(const ScheduleTable& table, std::uint32_t a, std::uint32_t b);

/// The groups that can keep `group` waiting, directly or through others: of higher priority, and able to meet
/// on a processor. A group without a processor of its own can meet every other; then all of them are analysed
/// as if they shared one processor, which is never better than what happens and often worse.
GroupSet rivals(const ScheduleTable& table, std::uint32_t group);

/// Share of one processor's time that `set` asks for at a level of the degrade ladder, 1.0 = all of it.
double utilisation(const ScheduleTable& table, GroupSet set, std::uint8_t level = 0);
/// True if `set` asks for more than one processor can give. Exact while its demand over a hyperperiod fits 64
/// bits, to 1e-12 beyond.
bool overloads(const ScheduleTable& table, GroupSet set);

/// Worst response of a group [ns], and how it is known.
struct ResponseBound {
  std::uint64_t ns{};
  bool known{};  ///< false: grows without bound, or not found within the limit; `ns` is then what was seen
};

/// Worst response if all rivals were released in the same instant, whatever the phases: iterated to its fixed
/// point. Exact for the first job, and thus for every response up to the period. At most 1000 iterations.
ResponseBound response_any_phase(const ScheduleTable& table, std::uint32_t group);

/// Worst response with the phases as they are: all releases from the start through the last phase and two
/// hyperperiods are played, after which everything repeats. Exact; not known when that takes more than
/// kMostReleases, or when a job is not done at its next release. Never above response_any_phase().
ResponseBound response_with_phases(const ScheduleTable& table, std::uint32_t group);

/// Releases that are played at most. Cost: about 20 ns each.
inline constexpr std::uint32_t kMostReleases = 1u << 17;

}  // namespace sortie::rt
