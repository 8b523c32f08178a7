// SPDX-License-Identifier: BSD-3-Clause
// Why a job started late or ran long: a pure decision over measured numbers. A cause needs positive evidence;
// what has none is unknown, and said so.
#pragma once

#include <cstdint>

#include "rt/time.hpp"

namespace sortie::rt::posix {

/// Where time went.
enum class DelayCause : std::uint8_t {
  own,  ///< the program's own work: CPU time charged to the thread beyond what was declared, or it blocked
  interrupt,  ///< interrupt handlers and signals: charged to the thread, but it did not get on
  run_queue,  ///< ready and kept waiting: another thread, or the kernel in a section without preemption
  stolen,   ///< nobody on this core ran: the hypervisor took the core, or the whole machine or process paused
  unknown,  ///< no evidence
};
inline constexpr int kDelayCauses = 5;

/// For a person: "own work", "interrupt", "run queue", "stolen", "unknown".
const char* to_string(DelayCause cause);

/// A delay, divided among its causes [ns].
struct DelaySplit {
  Nanoseconds ns[kDelayCauses]{};

  Nanoseconds& operator[](DelayCause cause) { return ns[static_cast<int>(cause)]; }
  Nanoseconds operator[](DelayCause cause) const { return ns[static_cast<int>(cause)]; }
  Nanoseconds total() const;
  /// The largest part; the first in the order of the enumeration where two are equal. Unknown when empty.
  DelayCause main_cause() const;
  /// Divides `late_ns` in the proportion of the parts: exact in sum. Nothing is invented: where the parts are
  /// less than `late_ns` the rest is unknown.
  DelaySplit fitted_to(Nanoseconds late_ns) const;
};

/// What was measured about one delay. All durations in ns, >= 0; zero where it does not apply.
struct DelaySample {
  Nanoseconds late_ns{};        ///< to be explained: start after the release, or execution beyond its budget
  Nanoseconds run_queue_ns{};   ///< growth of the thread's run-queue delay
  Nanoseconds timer_late_ns{};  ///< woken after the time asked for, run-queue delay taken off
  Nanoseconds uncharged_ns{};   ///< passed outside sleep, neither charged to the thread nor in the run queue
  Nanoseconds charged_ns{};     ///< CPU time of a job, charged to the thread
  Nanoseconds allowed_ns{};     ///< CPU time that was declared for it: no delay is blamed on that
  Nanoseconds disturbed_ns{};   ///< CPU time charged while it waited: it slept, or spun and did not get on
  bool switched{};              ///< the thread left the core of its own accord while `uncharged_ns` passed
  Nanoseconds pause_ns{};       ///< of that time, all heartbeats were missing
  std::uint32_t interrupts{};   ///< on this core at that time, beyond the usual
  bool steal_charged{};         ///< no steal clock: stolen time is charged to whoever seems to run
  bool guest_timer{};           ///< virtual machine with a steal clock: a late timer means a stolen core
  DelaySplit inherited;         ///< lateness that the wait began with: causes of the job before
};

/// CPU time that may be blamed on one interrupt beyond the usual [ns]: entry, handler, exit, cold caches, and
/// a signal's way to user space and back. Measured on a virtual machine: 7 to 9 us for a signal, 14 us for a
/// timer interrupt that finds four timers due; less on bare metal.
inline constexpr Nanoseconds kInterruptCostNs = 15'000;

/// Divides sample.late_ns among its causes. The parts add up to it exactly. Pure arithmetic on integers.
DelaySplit split_delay(const DelaySample& sample);

}  // namespace sortie::rt::posix
