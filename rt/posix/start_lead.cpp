// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/start_lead.hpp"

#include <algorithm>
#include <thread>

#include "rt/posix/clock.hpp"
#include "rt/posix/make_thread.hpp"
#include "rt/posix/stack_meter.hpp"

namespace sortie::rt::posix {

Nanoseconds measure_start_lead(unsigned threads, bool realtime) {
  constexpr Nanoseconds kLeast = 100 * kNanosecondsPerMillisecond;  // the caller looks for refusals meanwhile
  constexpr Nanoseconds kMost = 5 * kNanosecondsPerSecond;
  Nanoseconds slowest = 0;
  for (int trial = 0; trial < 3; ++trial) {
    const Nanoseconds begin = monotonic_now();
    Nanoseconds ready = begin;
    std::thread probe = make_thread("the start's trial", [realtime, &ready] {
      set_thread_name("probe");
      StackMeter stack;
      if (realtime) static_cast<void>(stack.paint(kPaintedStackBytes));
      ready = monotonic_now();
    });
    probe.join();
    slowest = std::max(slowest, ready - begin);
  }
  const Nanoseconds least_each = realtime ? 150 * kNanosecondsPerMillisecond : 0;
  return std::min(kLeast + std::max(4 * slowest, least_each) * static_cast<Nanoseconds>(threads), kMost);
}

}  // namespace sortie::rt::posix
