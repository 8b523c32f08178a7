// SPDX-License-Identifier: BSD-3-Clause
// From a log: which parts of its scene never mattered, and which that it lacks would have.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware_like/replay.hpp"

namespace sortie::firmware {

class Json;

/// What a replay with one part left out, or put in, says of it.
enum class PartVerdict : std::uint8_t {
  no_input,        ///< the log has no sample of what the part works on
  never_mattered,  ///< left out, nothing else changes, or the pose by less than anybody would see
  did_not_help,    ///< left out, the error is no larger
  mattered,        ///< left out, the error grows; without truth: the pose moves
  would_matter,    ///< put in, the error falls; without truth: the pose moves
  would_not,       ///< put in, it does not
  not_judged       ///< a replay cannot tell; `figure` says why
};

/// One part.
struct AdviceLine {
  std::string part;
  PartVerdict verdict{};
  std::string figure;     ///< one sentence with the figures that prove it
  double pose_moved_m{};  ///< the largest distance between both estimates at one time
  std::optional<double>
      error;  ///< of the scene as it is; of the place, or where there is none the inclination
  std::optional<double> changed;  ///< with the part left out, or put in
  std::int64_t bytes{};           ///< that leaving it out saves, or putting it in takes
  double us_per_tick{};           ///< the same, as far as one replay can tell
};

/// All of them, in the order of scene_parts().
struct Advice {
  std::string scene;
  std::string log;
  std::uint64_t ticks{};
  std::string judged_by;  ///< name of the error; empty: the log has no truth
  double most_inclined_deg{};
  std::vector<AdviceLine> lines;
};

/// Replays the log once for each part. A part that only acts on the robot (drive, flippers, flight) is not
/// judged: a log does not tell what would have happened without. Throws as replay() does.
Advice advise(const LogFile& log, const VehicleRegistry& vehicles, const ReplayOptions& options);

/// The object of --json, and one line a part.
Json to_json(const Advice& advice);
std::string advice_text(const Advice& advice);

}  // namespace sortie::firmware
