// SPDX-License-Identifier: BSD-3-Clause
// Jobs as a log holds them. A damaged event may say anything: what cannot be is refused here.
#pragma once

#include "drivers/wire_records.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

/// True when a job record can hold it.
bool fits_job_record(const drivers::TickRecord& tick);

/// Reads one tick record into a job record. False when it does not fit (other numbers of streams, inputs or
/// tasks).
bool to_job_record(const drivers::TickRecord& tick, rt::JobRecord& record);

/// The longest log that is replayed, a year: one wrong time must not keep a replay busy for ever.
rt::Tick most_ticks_of_a_log(const rt::Executive& executive);

}  // namespace sortie::firmware
