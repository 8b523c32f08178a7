// SPDX-License-Identifier: BSD-3-Clause
// Counted jobs for people and programs: table, JSON, CSV, and the text that gates a worst case.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "toolchain/bench/wcet.hpp"

namespace sortie::firmware {
class Json;
}  // namespace sortie::firmware

namespace sortie::toolchain {

void print_wcet(std::ostream& out, const Wcet& wcet);
/// {scene, built_by, tasks[]{name, group, jobs, median, p99, worst, worst_tick, total, ratio}}.
firmware::Json to_json(const Wcet& wcet);
/// tick,task,instructions: one row a job.
void write_wcet_csv(std::ostream& out, const Wcet& wcet);

/// The text that is committed as a gate: `command`, who built the program, one line a task.
std::string gate_text(const Wcet& wcet, const std::string& command);

/// What a comparison with a committed text gives.
struct WcetVerdict {
  std::string skipped;                ///< why the two cannot be compared, or empty
  std::vector<std::string> failures;  ///< one line for each figure that is not the same
};

/// Compares with the text of gate_text(), to the instruction. Throws InputError where `committed` is no such
/// text; `name` is its file.
WcetVerdict compare_wcet(const Wcet& wcet, const std::string& committed, const std::string& name);

}  // namespace sortie::toolchain
