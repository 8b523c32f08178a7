// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/clock.hpp"

#include <cerrno>
#include <ctime>

namespace sortie::rt::posix {
namespace {

Nanoseconds read_clock(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return Nanoseconds{t.tv_sec} * kNanosecondsPerSecond + t.tv_nsec;
}

}  // namespace

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

ReleaseWait wait_for_release(Nanoseconds wake_ns, Nanoseconds margin_ns) {
  ReleaseWait wait{0, -1, 0};
  Nanoseconds now = monotonic_now();
  if (wake_ns - now > margin_ns) {
    sleep_until(wake_ns - margin_ns);
    now = monotonic_now();
    wait.overslept_ns = now - (wake_ns - margin_ns);
  }
  const Nanoseconds spins_from = now;
  while (now < wake_ns) now = monotonic_now();
  wait.spun_ns = now - spins_from;
  wait.woke_ns = now;
  return wait;
}

}  // namespace sortie::rt::posix
