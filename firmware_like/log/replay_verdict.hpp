// SPDX-License-Identifier: BSD-3-Clause
// Whether a replay says that a log is good: what every program that checks logs says in the same words.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/log/replay.hpp"

namespace sortie::firmware {

/// Why a check of `log` fails, a line each: an output that differs, samples that the log does not hold,
/// streams of which nothing was used. Empty: it passes.
std::vector<std::string> check_failures(const LogFile& log, const ReplayOutcome& outcome);

/// Prints what a check found: as JSON the results with recorded_digest, compared_jobs, passed, failures and
/// divergence, else warnings on stderr and then FAILED lines or one that says what was compared. A part
/// (`is_part`) is named by its ticks, the keyframe's on.
void print_check(const LogFile& log, const ReplayOutcome& outcome, const std::vector<std::string>& failures,
                 bool is_part, bool json);

/// Exit code of a command that used a log: `code`, or 3 with a line on stderr that tells where the file is
/// damaged, unless its good part was declared to be enough. `program`: what the line begins with.
int code_with_damage(const std::string& program, const std::string& damage, bool accept_damage, int code);

}  // namespace sortie::firmware
