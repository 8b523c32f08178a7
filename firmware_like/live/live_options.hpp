// SPDX-License-Identifier: BSD-3-Clause
// What the `run` command of every program has in common.
#pragma once

#include "firmware_like/live/live_run.hpp"
#include "firmware_like/scene/command_line.hpp"

namespace sortie::firmware {

/// Declares --scene, --set, --seconds, --record and all else that says how a run goes.
void add_live_options(Command& command, LiveRunOptions& options);

/// Tells on stderr which files a run has left.
void tell_files(const LiveRunOutcome& outcome);

}  // namespace sortie::firmware
