// SPDX-License-Identifier: BSD-3-Clause
// Events in the log of a run: the one way in which they are put there, whatever tells them, and what is read
// again from those that end a run.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/result/finding.hpp"
#include "firmware_like/runtime/input_port.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

/// Writes `event` where the run's clock reads `run_time_ns`, and dates it by the offset that dates all of the
/// run (telemetry.hpp); 0 in simulated time. One that cannot be encoded is left out. Off the real-time path;
/// takes heap.
void log_event(SampleSink& log, drivers::EventRecord event, rt::Nanoseconds run_time_ns,
               rt::Nanoseconds utc_minus_run_ns);

/// The events of one kind, in the log's order, without those that are damaged.
std::vector<drivers::EventRecord> events_of(const LogFile& log, std::string_view kind);

/// Writes an event of kind `end`: the run had the ticks before `ticks`, which jobs alone do not say. What was
/// left out behind the last job, and before the first one, is counted by a replay because of this, as the run
/// itself has counted it.
void write_run_end(SampleSink& log, const rt::Executive& executive, rt::Tick ticks,
                   rt::Nanoseconds utc_minus_run_ns);

/// What it says; nothing in a log of simulated time, of a run that did not end in good order, or where it is
/// damaged.
std::optional<rt::Tick> run_end(const LogFile& log);

/// Kind of the event that holds a doctor's report as JSON.
inline constexpr const char* kDoctorEvent = "doctor";

/// What the doctor said about the machine that recorded a log; a note instead where the log does not hold it.
DoctorReport recorded_doctor(const LogFile& log);

}  // namespace sortie::firmware
