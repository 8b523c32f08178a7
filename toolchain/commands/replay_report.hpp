// SPDX-License-Identifier: BSD-3-Clause
// A replay whose outcome is shown: what `replay` and `report` have in common.
#pragma once

#include <string>

#include "firmware_like/log/replay_command.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/report/html.hpp"

namespace sortie::toolchain {

/// Options of a shown replay.
struct ReplayReportOptions : firmware::ReplayCommand {
  EvaluationOptions evaluation;
  std::string align{"none"};
};

/// Declares all but the log: what a replay may be told, how poses are compared, and what is accepted.
void add_replay_report_options(firmware::Command& command, ReplayReportOptions& options);

/// A replay and what a page tells about it.
struct ReplayedLog {
  ReportInput report;
  Plot ground;  ///< the map from above, without the path's frame; without series where there is none
  std::string damage;
  std::vector<std::string> failures;  ///< ReplayOutcome::failures
};

/// Replays `log`. Throws InputError, ProfileError.
ReplayedLog replay_for_report(const CommandContext& context, ReplayReportOptions& options,
                              const OutputOptions& output, const std::string& log);

}  // namespace sortie::toolchain
