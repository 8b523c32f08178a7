// SPDX-License-Identifier: BSD-3-Clause
// The real-time part of a live run: workers, bench, devices and requests, each on a thread of its own.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "firmware_like/link/event_desk.hpp"
#include "firmware_like/link/request_door.hpp"
#include "firmware_like/live/live_run.hpp"
#include "firmware_like/live/live_surroundings.hpp"
#include "firmware_like/runtime/chain_watch.hpp"

namespace sortie::firmware {

/// What the threads work with. All of it outlives the run.
struct LiveParts {
  Runtime& runtime;
  Surroundings& surroundings;
  RequestDoor& parameters;
  LogRecorder& recorder;
  EventDesk& desk;
  ChainWatch& chains;
};

/// What a live run measures of one group beside its histograms.
struct LiveGroup {
  double spinning{};   ///< share of a core spent spinning before releases
  double margin_us{};  ///< spin margin at the end
  std::uint64_t stack_bytes{};
  GroupDelays delays;
};

/// What the threads leave behind.
struct LiveMeasured {
  rt::Tick ticks{};
  std::string stopped;  ///< why the run ended before its time, or empty
  std::map<std::string, std::uint64_t> counters;
  std::vector<LiveGroup> groups;
  std::vector<std::string> warnings;  ///< what the platform refused
  std::string late_start;             ///< what a machine too busy at the start left out, or empty
};

/// How far ahead tick 0 must lie, so that every thread has been made and sleeps by then: measured now.
rt::Nanoseconds start_lead(const Runtime& runtime, bool realtime);

/// Runs ticks 0 to `last`, tick 0 at `start_ns` of CLOCK_MONOTONIC. Returns when all threads have ended. A
/// task that never ends closes the log and leaves the process (live.stuck_exit_ms).
LiveMeasured run_in_real_time(const LiveParts& parts, const LiveRunOptions& options, rt::Nanoseconds start_ns,
                              rt::Tick last);

}  // namespace sortie::firmware
