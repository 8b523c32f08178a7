// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/clock.hpp"

#include <cerrno>

namespace sortie::rt::posix {

Nanoseconds read_clock(clockid_t clock) noexcept {
  timespec t{};
  clock_gettime(clock, &t);
  return Nanoseconds{t.tv_sec} * kNanosecondsPerSecond + t.tv_nsec;
}

Nanoseconds monotonic_now() { return read_clock(CLOCK_MONOTONIC); }

Nanoseconds thread_cpu_now() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

Nanoseconds utc_minus_monotonic() {
  Nanoseconds best_gap = 0;
  Nanoseconds best = 0;
  for (int i = 0; i < 8; ++i) {
    const Nanoseconds before = monotonic_now();
    const Nanoseconds utc = read_clock(CLOCK_REALTIME);
    const Nanoseconds gap = monotonic_now() - before;
    if (i == 0 || gap < best_gap) {
      best_gap = gap;
      best = utc - (before + gap / 2);
    }
  }
  return best;
}

void sleep_until(Nanoseconds wake_ns) {
  if (wake_ns <= 0) return;
  timespec t{};
  t.tv_sec = static_cast<time_t>(wake_ns / kNanosecondsPerSecond);
  t.tv_nsec = static_cast<decltype(t.tv_nsec)>(wake_ns % kNanosecondsPerSecond);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

void nap_until(Nanoseconds wake_ns, const std::atomic<bool>& stop) {
  constexpr Nanoseconds kNap = 10 * kNanosecondsPerMillisecond;
  for (Nanoseconds now = monotonic_now(); now < wake_ns && !stop.load(std::memory_order_relaxed);
       now = monotonic_now())
    sleep_until(now + kNap < wake_ns ? now + kNap : wake_ns);
}

}  // namespace sortie::rt::posix
