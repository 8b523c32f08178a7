// SPDX-License-Identifier: BSD-3-Clause
// Finds the first place where two records of the same job differ: what it took and decided, and the outputs
// of its tasks, with recorded fields down to the field.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "firmware_like/runtime/chain_meter.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

/// The first place where two runs differ.
struct Divergence {
  rt::Tick tick{};
  std::string group;
  std::string task;   ///< empty where the job as a whole differs
  std::string field;  ///< of an output, with fields on both sides: "p_world_body_m[2]"; or what was decided:
                      ///< "samples of stream IMU", "jobs taken of task map", "level", "tasks left out",
                      ///< "cut", "units", "verdict"; empty for an output without fields
  std::string was;    ///< on the first side; of a field with its bits
  std::string is;     ///< on the second side
  bool decided{};     ///< `field` is not part of an output
};

/// Compares the outputs of two records of one job, task by task. Records of different inputs differ at their
/// first task.
std::optional<Divergence> compare_outputs(const rt::Executive& executive, const rt::JobRecord& first,
                                          const rt::JobRecord& second);

/// Compares everything else that is recorded of a job and is no measured time: the samples and the other
/// groups' jobs that it took, the level of the ladder and whom it left out, cuts, work units, verdict. A
/// replay is told most of these by the log, so a wrong one shows in what follows from it: a level in the
/// tasks that are left out and in their units, a cut in the unit that was refused, a verdict in what others
/// could take.
std::optional<Divergence> compare_decisions(const rt::Executive& executive, const rt::JobRecord& first,
                                            const rt::JobRecord& second);

/// Compares a recorded verdict with the times that a live run measured of the job. Whoever ended behind the
/// deadline has missed it. Who ended before it may have been called missed by a reader in that moment, unless
/// nobody reads the group nor takes its commands.
std::optional<Divergence> compare_with_times(const rt::Executive& executive, const rt::JobRecord& recorded,
                                             const JobTimes& times);

/// Of a recorded verdict that cannot be. `is`: what it must be.
Divergence wrong_verdict(const rt::Executive& executive, const rt::JobRecord& recorded, std::string is);

/// "done", "missed" or "pending".
const char* to_string(rt::Verdict verdict);

/// One line for a person: "first difference: tick 1200, task odometry (group control), field
/// p_world_body_m[2]: was ..., is ..."
std::string describe(const Divergence& divergence);

}  // namespace sortie::firmware
