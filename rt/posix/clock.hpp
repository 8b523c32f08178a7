// SPDX-License-Identifier: BSD-3-Clause
// The clocks of the operating system. Live executive, drivers and statistics only: no code whose output
// enters a digest reads a clock.
#pragma once

#include <ctime>

#include <atomic>

#include "rt/time.hpp"

namespace sortie::rt::posix {

/// CLOCK_MONOTONIC [ns]. About 20 ns a call, no system call.
Nanoseconds monotonic_now();

/// Any clock of the system [ns]; 0 when there is no such clock (any more). A signal handler may ask, too.
Nanoseconds read_clock(clockid_t clock) noexcept;

/// UTC minus CLOCK_MONOTONIC [ns]: add it to a monotonic stamp to get a date. The tightest of several
/// readings, good to about 100 ns; it moves when the system's clock is set.
Nanoseconds utc_minus_monotonic();

/// CPU time that the calling thread has used [ns]. About 0.4 us. Time stolen by a hypervisor is not in it.
Nanoseconds thread_cpu_now();

/// Sleeps until CLOCK_MONOTONIC reaches `wake_ns`, whatever signals come; not at all when that is past.
void sleep_until(Nanoseconds wake_ns);

/// The same in naps of 10 ms, for who waits for a run to begin: it ends within a nap of `stop` being set.
void nap_until(Nanoseconds wake_ns, const std::atomic<bool>& stop);

}  // namespace sortie::rt::posix
