// SPDX-License-Identifier: BSD-3-Clause
// What a thread asks of the kernel before it becomes a real-time thread. Every step may be refused on a
// desktop or in a container; then it says why and how to get it, and the caller decides whether to go on.
#pragma once

#include <cstddef>

#include "rt/time.hpp"

namespace sortie::rt::posix {

/// Outcome of one step: `reason` is one line for a person, with the cure, and empty when ok.
struct [[nodiscard]] SetupResult {
  bool ok{true};
  char reason[200]{};
};

/// A step that was refused, and why, as printf has it; cut to what fits.
[[gnu::format(printf, 1, 2)]] SetupResult refusal(const char* format, ...) noexcept;

/// SCHED_FIFO at `priority` (1..99) for the calling thread. Needs CAP_SYS_NICE or an RLIMIT_RTPRIO.
SetupResult set_fifo_priority(int priority) noexcept;

/// Ordinary scheduling (SCHED_OTHER, nice 0) for the calling thread: undoes set_fifo_priority.
SetupResult set_ordinary_priority() noexcept;

/// The number that the kernel knows the calling thread by.
int thread_number() noexcept;

/// The same as set_ordinary_priority() for another thread of this process, by its number: one that does not
/// end leaves the processor to ordinary threads from then on.
SetupResult take_priority_from(int thread) noexcept;

/// Keeps all present and future pages of the process in memory (mlockall); malloc gives none back then.
SetupResult lock_memory() noexcept;

/// Bounds the stack of every thread that is made from now on to `bytes`. Locked memory holds a stack whole
/// from the start: at the usual 8 MB, twelve threads take 96 MB and the time to clear them. Refused below 64
/// kB, or by a C library that cannot.
SetupResult bound_thread_stacks(std::size_t bytes) noexcept;

/// Binds the calling thread to one core (0-based).
SetupResult pin_to_core(int core) noexcept;

/// Cores this process may run on, at least 1.
int usable_cores() noexcept;

/// Touches `bytes` of the calling thread's stack, so that no page fault happens there later. Refused when
/// that is more than what is left of the stack, less 64 kB.
SetupResult prefault_stack(std::size_t bytes) noexcept;

/// How late an ordinary (not SCHED_FIFO) thread's timers may be grouped, usually 50 us; `slack_ns` >= 1.
SetupResult set_timer_slack(Nanoseconds slack_ns) noexcept;

/// Names the calling thread for top, perf and traces. Cut to 15 characters.
void set_thread_name(const char* name) noexcept;

/// Page faults of the calling thread since it started.
struct PageFaults {
  long minor{};
  long major{};
};
PageFaults thread_page_faults() noexcept;

}  // namespace sortie::rt::posix
