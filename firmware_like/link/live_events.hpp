// SPDX-License-Identifier: BSD-3-Clause
// Events of a live run in words: for the log, for spy, for the report.
#pragma once

#include "drivers/wire_records.hpp"
#include "rt/executive.hpp"
#include "rt/posix/live_event.hpp"

namespace sortie::firmware {

/// The event as a record; `utc_minus_run_ns` turns its tick into a date. Takes heap.
drivers::EventRecord to_record(const rt::posix::LiveEvent& event, const rt::Executive& executive,
                               rt::Nanoseconds utc_minus_run_ns);

}  // namespace sortie::firmware
