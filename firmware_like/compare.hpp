// SPDX-License-Identifier: BSD-3-Clause
// Finds the first place where two records of the same job differ: tick, task, and with recorded fields the
// field.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "rt/executive.hpp"

namespace sortie::firmware {

/// The first place where two runs differ.
struct Divergence {
  rt::Tick tick{};
  std::string group;
  std::string task;
  std::string field;  ///< with fields on both sides: "p_world_body_m[2]"; otherwise empty
  std::string was;    ///< value on the first side, with its bits
  std::string is;     ///< value on the second side
};

/// Compares two records of one job, task by task. Records of different inputs differ at their first task.
std::optional<Divergence> compare_jobs(const rt::Executive& executive, const rt::JobRecord& first,
                                       const rt::JobRecord& second);

/// One line for a person: "first difference: tick 1200, task odometry (group control), field
/// p_world_body_m[2]: ..."
std::string describe(const Divergence& divergence);

}  // namespace sortie::firmware
