// SPDX-License-Identifier: BSD-3-Clause
// Why jobs of a live run were late: causes by group, and the last delays one by one.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "rt/describe.hpp"

namespace sortie::rt::posix {
struct DelayStatistics;
}

namespace sortie::firmware {

class Json;

/// Delays with one cause.
struct CauseResult {
  std::uint64_t count{};  ///< delays whose main cause it is
  double total_us{};      ///< its part of all delays
  SORTIE_FIELDS(count, total_us)
};

/// All delays of one kind: jobs that started late, or ran beyond their budget.
struct DelayTableResult {
  std::uint64_t outliers{};     ///< above the threshold
  double raw_max_us{};          ///< start: lateness; execution: wall time
  double clean_max_us{};        ///< the same without those whose cause lies outside the program
  std::uint64_t clean_count{};  ///< how many that leaves
  std::map<std::string, CauseResult> causes;
  SORTIE_FIELDS(outliers, raw_max_us, clean_max_us, clean_count)
};

/// One delay.
struct DelayResult {
  std::uint64_t tick{};
  std::string kind;   ///< "start" or "execution"
  double late_us{};   ///< after the release, or beyond the budget
  std::string cause;  ///< the largest part
  std::map<std::string, double> split_us;
  SORTIE_FIELDS(tick, kind, late_us, cause)
};

/// Delays of one group. `known` false: attribution was off or refused.
struct GroupDelays {
  bool known{};
  DelayTableResult start;
  DelayTableResult execution;
  std::vector<DelayResult> last;  ///< oldest first
};

Json to_json(const GroupDelays& delays);
/// Reads back what to_json wrote. Throws std::runtime_error naming the key if a value has the wrong type.
GroupDelays delays_from_json(const Json& object, const std::string& place);

/// What the observer of a group has found.
GroupDelays collect_delays(const rt::posix::DelayStatistics& statistics);

}  // namespace sortie::firmware
