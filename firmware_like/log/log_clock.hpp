// SPDX-License-Identifier: BSD-3-Clause
// What the clock of a machine read at time 0 of a log: so that two logs of the same machine, a runtime's and
// its plant's, can be laid side by side.
#pragma once

#include <string>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/runtime/input_port.hpp"

namespace sortie::firmware {

/// Writes CLOCK_MONOTONIC at time 0 of the log, and which start of the machine it counts from: an event of
/// kind `clock`.
void write_log_clock(SampleSink& log, rt::Nanoseconds zero_ns, rt::Nanoseconds utc_minus_log_ns);

/// How two logs lie in time.
struct ClockOffset {
  std::int64_t offset_ns{};  ///< stamp in the run's log = stamp in the other log + this
  bool exact{};              ///< by the same clock; otherwise by UTC, as good as the machines' dates agree
};

/// From the clock events of both logs or, where those are missing or of another start of the machine, from
/// their UTC. Throws InputError when one of them has neither.
ClockOffset clock_offset(const LogFile& run, const LogFile& other);

/// Opens the log of a plant that truth is taken from and says how it lies to the run's. Throws InputError
/// when the log holds no truth, or none of that time.
struct TruthLog {
  explicit TruthLog(const LogFile& run, const std::string& path);
  LogFile log;
  ClockOffset offset;
  Trajectory poses;  ///< on the run's clock
};

}  // namespace sortie::firmware
