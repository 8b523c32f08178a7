// SPDX-License-Identifier: BSD-3-Clause
// The verdict on a declared table: what every group and processor has to bear, and what is worth saying.
#pragma once

#include <cstdint>

#include "rt/phases.hpp"
#include "rt/schedule.hpp"

namespace sortie::rt {

/// One group's figures.
struct GroupReport {
  std::uint32_t priority{};      ///< 0: most urgent of the table
  double utilisation{};          ///< of one processor
  std::uint64_t budget_ns{};     ///< declared worst run time of a job
  std::uint64_t deadline_ns{};   ///< after the release
  ResponseBound any_phase;       ///< worst response, whatever the phases
  ResponseBound with_phases;     ///< worst response with the phases as they are
  ResponseBound worst() const {  ///< the sharper one that is known
    return with_phases.known ? with_phases : any_phase;
  }
  bool fits{};  ///< worst() is known and not beyond the deadline
};

/// One processor's figures. Groups that may run anywhere are counted on every one.
struct CoreReport {
  int core{-1};                   ///< -1: the table names no processor
  double utilisation[kLevels]{};  ///< by level of the degrade ladder; [0] is everything
  TickLoad tick;                  ///< worst tick and longest time without a pause
};

/// What kind of thing is worth saying.
enum class FindingKind : std::uint8_t {
  overload,          ///< processor `core` is asked for more than all of its time
  late,              ///< group `a` can be done after its deadline
  nearly_full,       ///< processor `core` is asked for more than kMostUtilisation
  not_harmonic,      ///< neither the period of group `a` nor that of `b` divides the other
  long_hyperperiod,  ///< the pattern repeats after more than 2^63 ticks, or too late to be played
  one_processor      ///< groups that may run anywhere were analysed as if on one processor
};

/// One thing worth saying, with the numbers that belong to it.
struct Finding {
  FindingKind kind{};
  std::uint32_t a{};
  std::uint32_t b{};
  int core{-1};
};

/// Beyond this share of a processor the kernel itself takes real-time threads off it, some 50 ms at a time.
inline constexpr double kMostUtilisation = 0.9;

/// Everything there is to say about a table.
struct ScheduleReport {
  std::uint64_t hyperperiod_ticks{};  ///< 0: longer than 2^63 ticks
  bool harmonic{true};
  bool schedulable{true};  ///< every group fits
  FixedVector<GroupReport, kMaxGroups> groups;
  FixedVector<CoreReport, kMaxGroups> cores;
  FixedVector<Finding, 2 * kMaxGroups + 4> findings;  ///< the worst first
};

/// Analyses `table` with its phases. Set-up only; at most some 10 ms.
ScheduleReport analyse(const ScheduleTable& table);

}  // namespace sortie::rt
