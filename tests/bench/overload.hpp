// SPDX-License-Identifier: BSD-3-Clause
// What happens at twice the demand: a table of tasks of criticality A, B and C on one core, driven into
// overload again and again by the real live runner.
#pragma once

#include <cstdint>
#include <vector>

namespace sortie::bench {

/// What one round of overload has shown.
struct OverloadRound {
  std::uint64_t a_lost{};      ///< releases of A that were missed or left out while demand was doubled
  std::uint64_t b_shed{};      ///< jobs of B that the ladder left out
  std::uint64_t c_shed{};      ///< jobs of C that the ladder left out
  std::uint8_t worst_level{};  ///< of the ladder
  bool in_order{};             ///< B was shed only while C was off
  double first_step_ms{};      ///< from the doubling to the first step of the ladder
  double recovery_ms{};        ///< from the end of the doubling to level 0
};

/// How to measure.
struct OverloadOptions {
  int rounds{10};
  int core{1};         ///< the core that carries it all; another is needed for the rest of the machine
  double factor{2.0};  ///< of the declared demand: A 20 %, B 25 %, C 25 % of the core
  bool realtime{true};
};

/// Result of all rounds. `a_lost_calm` is the control: releases of A lost in equally long calm times before
/// each round, by the machine's own doing.
struct OverloadResult {
  std::vector<OverloadRound> rounds;
  std::uint64_t a_lost_calm{};
  std::uint64_t a_releases{};  ///< in the doubled times
  std::vector<const char*> refused;
};

/// Takes about half a second a round. Set-up code; throws std::system_error without threads.
OverloadResult measure_overload(const OverloadOptions& options);

/// How soon the watchdog told of a stuck task: time since the job began, in periods of its group, one a case.
std::vector<double> measure_watchdog(int cases, const OverloadOptions& options);

}  // namespace sortie::bench
