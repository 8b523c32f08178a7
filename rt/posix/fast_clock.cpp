// SPDX-License-Identifier: BSD-3-Clause
// The fast clock's writer: choice of the counter, its rate, and the line that follows CLOCK_MONOTONIC.
#include "rt/posix/fast_clock.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace sortie::rt::posix {

#if SORTIE_CYCLE_COUNTER
namespace detail {
constinit ClockLineCell fast_clock_cell;
}
#endif

namespace {

FastClockState state{FastClockSource::system, 0, "not started"};
bool started = false;

#if SORTIE_CYCLE_COUNTER

constexpr Nanoseconds kSpanNs = 2'500'000'000;
constexpr std::uint32_t kWindow = 4;  // samples that the slope is measured over: about 5 s

ClockLine newest_line;
ClockSample samples[kWindow];  // a ring, samples[sample_count % kWindow] is the oldest once it is full
std::uint32_t sample_count = 0;

// The reading of both clocks with the least between them: a preempted one loses.
ClockSample sample_clocks(int tries) {
  ClockSample best;
  std::uint64_t best_gap = ~std::uint64_t{0};
  for (int i = 0; i < tries; ++i) {
    const std::uint64_t before = detail::read_cycles();
    const Nanoseconds time = monotonic_now();
    const std::uint64_t gap = detail::read_cycles() - before;
    if (gap < best_gap) {
      best_gap = gap;
      best = {before + gap / 2, time};
    }
  }
  return best;
}

void keep_sample(const ClockSample& sample) { samples[sample_count++ % kWindow] = sample; }

bool kernel_keeps_time_by(const char* name) {
  char text[32]{};
  const int file =
      open("/sys/devices/system/clocksource/clocksource0/current_clocksource", O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const ssize_t got = read(file, text, sizeof(text) - 1);
  close(file);
  const std::size_t length = std::strlen(name);
  return got > 0 && std::strncmp(text, name, length) == 0 && (text[length] == '\n' || text[length] == '\0');
}

FastClockSource usable_counter() {
#ifdef __x86_64__
  unsigned a = 0;
  unsigned b = 0;
  unsigned c = 0;
  unsigned d = 0;
  const bool invariant = __get_cpuid(0x80000007u, &a, &b, &c, &d) != 0 && (d & (1u << 8)) != 0;
  if (!invariant) state.why_system = "the time stamp counter is not invariant";
  if (invariant && kernel_keeps_time_by("tsc")) return FastClockSource::tsc;
  if (invariant) state.why_system = "the kernel's clock source is not tsc";
#else
  if (kernel_keeps_time_by("arch_sys_counter")) return FastClockSource::arch_counter;
  state.why_system = "the kernel's clock source is not arch_sys_counter";
#endif
  return FastClockSource::system;
}

#endif

}  // namespace

FastClockSource start_fast_clock() {
  if (started) return state.source;
  started = true;
#if SORTIE_CYCLE_COUNTER
  state.source = usable_counter();
  if (state.source == FastClockSource::system) return state.source;
  const ClockSample first = sample_clocks(200);
  sleep_until(first.time_ns + 50 * kNanosecondsPerMillisecond);
  const ClockSample second = sample_clocks(200);
  if (second.cycles <= first.cycles || second.time_ns <= first.time_ns) {
    state.source = FastClockSource::system;
    state.why_system = "the counter stands still";
    return state.source;
  }
  const std::int64_t slope = clock_slope(first, second);
  const ClockLine::Wide span = (static_cast<ClockLine::Wide>(kSpanNs) << ClockLine::kShift) / slope;
  newest_line = ClockLine::through(second, slope, static_cast<std::uint64_t>(span));
  keep_sample(second);
  state.anchors = 1;
  state.why_system = "";
  detail::fast_clock_cell.publish(newest_line);
#else
  state.why_system = "no cycle counter is known for this processor";
#endif
  return state.source;
}

void anchor_fast_clock() {
#if SORTIE_CYCLE_COUNTER
  if (state.source == FastClockSource::system) return;
  if (!newest_line.due(detail::read_cycles())) return;
  const ClockSample now = sample_clocks(16);
  const ClockSample& oldest = samples[sample_count < kWindow ? 0 : sample_count % kWindow];
  const bool usable = now.cycles > oldest.cycles && now.time_ns > oldest.time_ns;
  const ClockStep step =
      continue_line(newest_line, now, usable ? clock_slope(oldest, now) : newest_line.after);
  newest_line = step.line;
  detail::fast_clock_cell.publish(newest_line);
  if (step.stepped_back || !usable) sample_count = 0;  // the rate over a pause is not the counter's
  keep_sample(now);
  ++state.anchors;
#endif
}

FastClockState fast_clock_state() { return state; }

}  // namespace sortie::rt::posix
