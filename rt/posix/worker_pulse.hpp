// SPDX-License-Identifier: BSD-3-Clause
// What a live worker lets the supervisor see, what the supervisor tells it, and what both tell of the run.
// Plain atomics; nobody waits.
#pragma once

#include <ctime>

#include <atomic>
#include <cstdint>

#include "rt/spsc_ring.hpp"
#include "rt/time.hpp"

namespace sortie::rt::posix {

/// Kinds of events that a live run tells while it goes on.
enum class LiveEventKind : std::uint8_t {
  ladder,   ///< `core` took another level: `value`
  stuck,    ///< task `task` of `group` runs for longer than a period; `value`: microseconds so far
  unstuck,  ///< it has ended after all; `value`: microseconds that it was stuck for at least
  promise,  ///< `group` broke its (m,k) promise; `value`: times so far
  stop      ///< `group` was late and its policy is to stop the run
};

/// One event. Plain; crosses threads in a ring.
struct LiveEvent {
  LiveEventKind kind{};
  std::int16_t core{-1};
  std::uint16_t group{};
  std::uint16_t task{};  ///< index within the group
  Tick tick{};
  std::int64_t value{};
};

/// Shared by one worker and the supervisor. One cache line for what changes each job.
struct alignas(64) WorkerPulse {
  SpscRing<LiveEvent, 64> events;  ///< to the thread that reads LiveRunner::poll_event()
  // Written by the worker.
  std::atomic<Nanoseconds> busy_since_ns{0};  ///< CLOCK_MONOTONIC when the running job began; 0: idle
  std::atomic<Nanoseconds> spun_ns{0};        ///< time spent spinning before releases
  std::atomic<int> thread{0};                 ///< its number in the kernel (thread_number()); 0: it has ended
  clockid_t cpu_clock{};                      ///< CPU time of the worker's thread
  std::atomic<std::uint32_t> missed{0};       ///< jobs missed or left out, modulo 2^32
  std::atomic<bool> has_cpu_clock{false};     ///< `cpu_clock` may be read
  // Written by the supervisor.
  std::atomic<std::uint8_t> level{0};  ///< of the degrade ladder, taken at the next release
};

}  // namespace sortie::rt::posix
