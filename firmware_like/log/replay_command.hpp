// SPDX-License-Identifier: BSD-3-Clause
// What `replay` and `check` take and how `check` ends: in the program of one scene and at the desk.
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
/// Adds --map: what a log that was recorded with a map needs.
void add_map_option(Command& command, std::string& map);
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

/// Prints what a check found and gives the exit code: 0, 1 where there are failures, 3 for damage that was
/// not accepted. `program`: what a line about damage begins with.
int end_check(const std::string& program, const LogFile& log, const ReplayOutcome& outcome,
              const std::vector<std::string>& failures, const ReplayCommand& command, bool json);

}  // namespace sortie::firmware
