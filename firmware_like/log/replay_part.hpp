// SPDX-License-Identifier: BSD-3-Clause
// What of a log is replayed, and whether it can be compared with what was recorded.
#pragma once

#include <string>

#include "firmware_like/log/replay.hpp"

namespace sortie::firmware {

/// Cuts the feed to the part that was asked for, restores the state of the outcome's runtime at its
/// beginning, and sets the outcome's ticks. Throws InputError.
void choose_part(const LogFile& log, const ReplayOptions& options, ReplayOutcome& outcome, LogFeed& feed);

/// True when the recorded jobs are in the message that this program reads.
bool reads_ticks(const LogFile& log);

/// Empty, or why the digests of this replay and those of the log are not of the same thing.
std::string why_not_comparable(const LogFile& log, const ReplayOptions& options, const Runtime& runtime);

/// Throws InputError (exit code 2) with the cure when the log's vehicle is none of `vehicles`.
void refuse_unknown_vehicle(const LogFile& log, const VehicleRegistry& vehicles);

}  // namespace sortie::firmware
