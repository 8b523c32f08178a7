// SPDX-License-Identifier: BSD-3-Clause
// The one way in which a run puts an event into its log, whatever tells it.
#pragma once

#include "drivers/wire_records.hpp"
#include "firmware_like/runtime/input_port.hpp"

namespace sortie::firmware {

/// Writes `event` where the run's clock reads `run_time_ns`, and dates it by the offset that dates all of the
/// run (telemetry.hpp); 0 in simulated time. One that cannot be encoded is left out. Off the real-time path;
/// takes heap.
void log_event(SampleSink& log, drivers::EventRecord event, rt::Nanoseconds run_time_ns,
               rt::Nanoseconds utc_minus_run_ns);

}  // namespace sortie::firmware
