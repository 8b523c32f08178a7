// SPDX-License-Identifier: BSD-3-Clause
// What `replay` and `check` take, and how `check` says whether a log is good: in the same words in the
// program of one scene and at the desk.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/log/replay.hpp"
#include "firmware_like/scene/command_line.hpp"

namespace sortie::firmware {

/// A log and how a command replays it.
struct ReplayCommand {
  std::string log;
  ReplayOptions replay;
  bool accept_damage{};
};

/// Adds --scene: another than the log's.
void add_scene_option(Command& command, std::string& scene);
/// Adds --from, --to and --keyframes. `has_index`: the program also makes keyframes.
void add_span_options(Command& command, ReplayOptions& options, bool has_index);
/// Adds --map, --targets and --images: what a log that was recorded with them needs.
void add_map_options(Command& command, KeptMapPaths& maps);
/// Adds --threads: a replay must give the same outputs with them.
void add_threads_option(Command& command, ReplayOptions& options);
/// Adds --fault.
void add_fault_option(Command& command, ReplayOptions& options);
/// Adds --record.
void add_record_option(Command& command, ReplayOptions& options);
/// Adds --accept-damage.
void add_damage_option(Command& command, bool& accept_damage);
/// Adds --accept-unused and --accept-damage.
void add_acceptance_options(Command& command, ReplayCommand& options);

/// Why a check of `log` fails, a line each: an output that differs, samples that the log does not hold,
/// streams of which nothing was used. Empty: it passes.
std::vector<std::string> check_failures(const LogFile& log, const ReplayOutcome& outcome);

/// Prints what a check found: as JSON the results with recorded_digest, compared_jobs, passed, failures and
/// divergence, else warnings on stderr and then FAILED lines or one that says what was compared; a part is
/// named by its ticks, the keyframe's on. Gives the exit code: 0, 1 where there are failures, 3 for damage
/// that was not accepted. `program`: what a line about damage begins with.
int end_check(const std::string& program, const LogFile& log, const ReplayOutcome& outcome,
              const std::vector<std::string>& failures, const ReplayCommand& command, bool json);

/// Exit code of a command that used a log: `code`, or 3 with a line on stderr that tells where the file is
/// damaged, unless its good part was declared to be enough. `program`: what the line begins with.
int code_with_damage(const std::string& program, const std::string& damage, bool accept_damage, int code);

}  // namespace sortie::firmware
