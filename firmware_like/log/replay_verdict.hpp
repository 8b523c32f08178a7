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

/// "passed  ...": what was compared, or of an imported log only run, and its digest. A part (`is_part`) is
/// named by its ticks, the keyframe's on.
std::string passed_line(const LogFile& log, const ReplayOutcome& outcome, bool is_part);

/// Exit code of a command that used a log: `code`, or 3 with a line on stderr that tells where the file is
/// damaged, unless its good part was declared to be enough. `program`: what the line begins with.
int code_with_damage(const std::string& program, const std::string& damage, bool accept_damage, int code);

}  // namespace sortie::firmware
