// SPDX-License-Identifier: BSD-3-Clause
// Runs a log through a vehicle on a virtual clock, and compares what comes out with what was recorded.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware_like/log/compare.hpp"
#include "firmware_like/log/contact_truth.hpp"
#include "firmware_like/log/log_feed.hpp"
#include "firmware_like/log/log_file.hpp"
#include "firmware_like/log/timed_pose.hpp"
#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

/// How to replay.
struct ReplayOptions {
  std::string scene;                   ///< empty: the profile that stands in the log
  std::vector<std::string> overrides;  ///< key=value each: "what if"
  KeptMapPaths maps;   ///< that the run begins with; a log that was recorded with one needs it
  std::string truth;   ///< log of the plant, where it ran in a process of its own; empty: the log's own truth
  bool threaded{};     ///< one worker a group instead of one thread: same outputs, for perturbation tests
  std::string fault;   ///< "task@tick" or "task.byte@tick": flip a bit there; proves that a check can fail
  std::string record;  ///< write a log of this replay (outputs of a what-if), or empty
  /// Refuse with InputError (exit code 2), before anything is run, what could not be compared.
  bool must_compare{};
  bool accept_unused{};  ///< a stream of which nothing is used is a warning only
  /// Begin there: seconds since the start or "@tick"; empty: at the start. The state comes from the nearest
  /// keyframe before it; without a file of keyframes the log is run from its start, silently until there.
  std::string from;
  std::string to;         ///< end before it; empty: at the end
  std::string keyframes;  ///< file of keyframes; empty: the log's own, if there is one
  /// Before the jobs of each tick, one thread only: keyframes are taken here.
  std::function<void(rt::Tick, Runtime&, LogFeed&)> on_tick;
  std::function<void(double share)> progress;                  ///< now and then, 0..1
  std::function<void(Runtime&)> before_run;                    ///< when all is set up, before the first job
  std::function<void(const rt::JobRecord&, Runtime&)> on_job;  ///< after each job, on the thread that ran it
};

/// What came out. `comparable`: the log has ticks and was replayed with its own scene, so digests can be
/// compared.
struct ReplayOutcome {
  Results results;
  Trajectory estimate;
  Trajectory located;  ///< of the body on the map that the robot made; empty without one
  Trajectory truth;
  std::vector<ContactSummary> contacts;  ///< truth of contacts and flippers, if a simulation wrote it
  bool comparable{};
  std::string why_not_comparable;
  std::string damage;                 ///< empty, or where the log is cut off or damaged
  std::vector<std::string> failures;  ///< why the command ends with 1: streams of which nothing was used,
                                      ///< and, of a simulated run, declared bounds that were exceeded
  LogDigest recorded;
  std::optional<Divergence> divergence;  ///< the first one, in order of ticks and groups
  std::uint64_t diverged_jobs{};
  std::uint64_t compared_jobs{};     ///< jobs whose outputs were compared with what the log holds of them
  rt::Tick begin_tick{};             ///< the first that was run: the keyframe's, or the log's first
  rt::Tick first_tick{};             ///< asked for, or the log's first
  rt::Tick restored_tick{};          ///< of the keyframe that the replay began with; 0: none
  std::unique_ptr<Runtime> runtime;  ///< as the replay left it: the map is still there
};

/// The runtime that a replay runs, with its map, as it is before the first job. Throws InputError,
/// ProfileError.
std::unique_ptr<Runtime> make_replay_runtime(const LogFile& log, const VehicleRegistry& vehicles,
                                             const ReplayOptions& options);

/// Replays a log. Throws InputError, ProfileError.
ReplayOutcome replay(const LogFile& log, const VehicleRegistry& vehicles, const ReplayOptions& options);

}  // namespace sortie::firmware
