// SPDX-License-Identifier: BSD-3-Clause
// The declared table and the chains as a result shows them: what was computed before the run, and what was
// measured in it.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "rt/describe.hpp"

namespace sortie::firmware {

class Json;

/// What was computed for a group. Times in microseconds.
struct ScheduledGroup {
  std::string name;
  double period_us{};
  double phase_us{};
  double deadline_us{};
  int core{-1};                    ///< -1: any
  std::uint64_t priority{};        ///< 0: most urgent
  double utilisation{};            ///< of one processor
  double budget_us{};              ///< of a whole job
  double response_us{};            ///< worst, with these phases; NaN: without bound
  double response_any_phase_us{};  ///< worst, whatever the phases; NaN: without bound
  bool fits{};
  SORTIE_FIELDS(name, period_us, phase_us, deadline_us, core, priority, utilisation, budget_us, response_us,
                response_any_phase_us, fits)
};

/// What was computed for a processor.
struct ScheduledCore {
  int core{-1};                     ///< -1: the table names none
  std::vector<double> utilisation;  ///< at each level of the degrade ladder, everything first
  double worst_tick_us{};           ///< declared work that waits at the worst release
  double longest_block_us{};        ///< without a pause
};

/// The table and its verdict.
struct ScheduleResult {
  double base_tick_us{};
  std::uint64_t hyperperiod_ticks{};  ///< 0: longer than 2^63
  bool harmonic{};
  bool schedulable{};
  std::vector<ScheduledGroup> groups;
  std::vector<ScheduledCore> cores;
  std::vector<std::string> findings;
  SORTIE_FIELDS(base_tick_us, hyperperiod_ticks, harmonic, schedulable)
};

/// p50, p99 and max of what was measured, in microseconds.
struct ChainFigures {
  std::uint64_t count{};
  double p50_us{};
  double p99_us{};
  double max_us{};
  SORTIE_FIELDS(count, p50_us, p99_us, max_us)
};

/// One chain: computed beside measured.
struct ChainResult {
  std::string name;
  std::vector<std::string> path;
  bool exact{};              ///< the computed figures are reached, not merely never passed
  double reaction_us{};      ///< computed: sample to the first output that knows of it
  double age_us{};           ///< computed: newest sample behind an output when that becomes visible
  double max_reaction_us{};  ///< bound in the profile; 0: none
  double max_age_us{};
  double source_interval_us{};      ///< declared
  double source_interval_max_us{};  ///< measured
  ChainFigures reaction;
  ChainFigures age;
  ChainFigures finished;  ///< live: sample to the end of the last task; counts nothing otherwise
  std::uint64_t unmeasured{};
  std::uint64_t reactions_over{};  ///< samples above max_reaction_us
  std::uint64_t ages_over{};       ///< outputs above max_age_us
  double reaction_over_max_us{};   ///< the longest of those; 0: none
  double age_over_max_us{};
  SORTIE_FIELDS(name, path, exact, reaction_us, age_us, max_reaction_us, max_age_us, source_interval_us,
                reactions_over, ages_over, reaction_over_max_us,
                age_over_max_us)  // what is known in any case
};

Json to_json(const ScheduleResult& schedule);
Json to_json(const ChainResult& chain);

/// The table of groups with its verdict and findings, for a person: about as many lines as groups and
/// processors.
void print_schedule(std::ostream& out, const ScheduleResult& schedule);
/// The chains: bounds, and beside them what was measured if anything was.
void print_chains(std::ostream& out, const std::vector<ChainResult>& chains);

}  // namespace sortie::firmware
