// SPDX-License-Identifier: BSD-3-Clause
// Chains that a vehicle or a profile declares: found in the table, bounded, held to what is allowed.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/result/results_schedule.hpp"
#include "firmware_like/runtime/arrivals.hpp"
#include "firmware_like/scene/profile.hpp"
#include "rt/chains.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

class VehicleBuilder;

/// A chain as it is declared: [chains.NAME]. A vehicle gives defaults, a profile overrides them or adds its
/// own.
struct ChainSpec {
  std::string name;
  std::vector<std::string> path;  ///< a stream or a task, then tasks
  double max_reaction_ms{};       ///< 0: no bound
  double max_age_ms{};            ///< 0: no bound
  double source_interval_ms{};    ///< longest time between two samples; 0: one arrives for every release
};

/// A chain of a sealed table.
struct DeclaredChain {
  ChainSpec spec;
  rt::Chain chain;
  rt::ChainBound bound;
  const Arrivals* arrivals{};  ///< of its stream; null if it begins with a task
};

/// Reads [chains], finds each chain and bounds it. Streams at the beginning of a chain keep their arrival
/// times from here on. Throws ProfileError when a path does not exist, a bound is exceeded, or one is
/// declared that cannot be computed (ChainWatch has the rule). `warnings`: streams that come faster than
/// their batches are taken.
std::vector<DeclaredChain> read_chains(Profile& profile, VehicleBuilder& builder,
                                       const rt::Executive& executive, std::vector<std::string>& warnings);

/// The computed half of a result.
ChainResult chain_result(const DeclaredChain& chain);

}  // namespace sortie::firmware
