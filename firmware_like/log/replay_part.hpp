// SPDX-License-Identifier: BSD-3-Clause
// What of a log is replayed, and whether it can be compared with what was recorded.
#pragma once

#include <string>

#include "firmware_like/log/replay.hpp"

namespace sortie::firmware {

/// The part of a log that a replay covers.
struct ReplayPart {
  rt::Tick asked{};     ///< first tick of interest
  rt::Tick begin{};     ///< first tick that is run
  rt::Tick restored{};  ///< keyframe, or 0
};

/// Cuts the feed to the part that was asked for and restores the state at its beginning. Throws InputError.
ReplayPart choose_part(const LogFile& log, const ReplayOptions& options, Runtime& runtime, LogFeed& feed);

/// True when the recorded jobs are in the message that this program reads.
bool reads_ticks(const LogFile& log);

/// Empty, or why the digests of this replay and those of the log are not of the same thing.
std::string why_not_comparable(const LogFile& log, const ReplayOptions& options, const Runtime& runtime);

/// Throws InputError (exit code 2) with the cure when the log's vehicle is none of `vehicles`.
void refuse_unknown_vehicle(const LogFile& log, const VehicleRegistry& vehicles);

}  // namespace sortie::firmware
