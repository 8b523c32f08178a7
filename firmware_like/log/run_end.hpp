// SPDX-License-Identifier: BSD-3-Clause
// How far a live run came, told in its log: jobs alone do not say it. What was left out behind the last job,
// and before the first one, is counted by a replay because of this, as the run itself has counted it.
#pragma once

#include <optional>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/runtime/input_port.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

/// Writes an event of kind `end`: the run had the ticks before `ticks`.
void write_run_end(SampleSink& log, const rt::Executive& executive, rt::Tick ticks,
                   rt::Nanoseconds utc_minus_run_ns);

/// What it says; nothing in a log of simulated time, of a run that did not end in good order, or where it is
/// damaged.
std::optional<rt::Tick> run_end(const LogFile& log);

}  // namespace sortie::firmware
