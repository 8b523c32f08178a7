// SPDX-License-Identifier: BSD-3-Clause
// CLOCK_MONOTONIC at half the price, for measuring spans: the processor's own counter, scaled.
//
// Used only where the kernel itself keeps time by that counter (then it is invariant and equal on all cores);
// elsewhere, and before start_fast_clock(), fast_now() is clock_gettime.
#pragma once

#include <atomic>
#include <cstdint>

#include "rt/posix/clock.hpp"
#include "rt/posix/clock_line.hpp"

#if SORTIE_CLOCK_LINE && (defined(__x86_64__) || defined(__aarch64__))
#define SORTIE_CYCLE_COUNTER 1
#else
#define SORTIE_CYCLE_COUNTER 0
#endif

namespace sortie::rt::posix {

/// What fast_now() reads.
enum class FastClockSource : std::uint8_t {
  system,        ///< clock_gettime(CLOCK_MONOTONIC)
  tsc,           ///< x86-64: invariant time stamp counter
  arch_counter,  ///< aarch64: virtual counter CNTVCT_EL0
};

/// What the fast clock is.
struct FastClockState {
  FastClockSource source{FastClockSource::system};
  std::uint32_t anchors{};     ///< lines so far
  const char* why_system{""};  ///< why it is not a counter, for a person
};

/// Chooses the source and measures the counter's rate. Takes about 60 ms; once per process, before threads
/// that use fast_now() start (a second call returns at once).
FastClockSource start_fast_clock();

/// Keeps the fast clock on CLOCK_MONOTONIC. Call it from one thread that is not a real-time thread, at least
/// once a second: 10 ns where nothing is to be done, about 1 us each 2.5 s. Without these calls the clock
/// falls behind by 0.1 % from 2.5 s on, and is set right by the next one. The error stays below 1 us (20 ns
/// measured on an idle machine). fast_now() never runs backwards on a thread, except after a suspend. Between
/// threads a reading may be as old as the loads that the processor still waits for (1 us measured): ordering
/// the counter read would cost 6 ns.
void anchor_fast_clock();

/// State so far. From the thread that anchors.
FastClockState fast_clock_state();

namespace detail {

#if SORTIE_CYCLE_COUNTER
inline std::uint64_t read_cycles() noexcept {
#ifdef __x86_64__
  return __builtin_ia32_rdtsc();
#else
  std::uint64_t cycles = 0;
  asm volatile("mrs %0, cntvct_el0" : "=r"(cycles));
  return cycles;
#endif
}

/// The newest line. One writer; a reader tries again only if it slept through three anchors.
class ClockLineCell {
 public:
  static constexpr std::uint32_t kSlots = 4;

  bool empty() const noexcept { return newest_.load(std::memory_order_relaxed) == 0; }

  void publish(const ClockLine& line) noexcept {
    const std::uint32_t number = newest_.load(std::memory_order_relaxed) + 1;
    Slot& slot = slots_[number % kSlots];
    // Released one by one: who sees one of these values also sees that the slot is being used again.
    slot.start_cycles.store(line.start_cycles, std::memory_order_release);
    slot.start_ns.store(line.start_ns, std::memory_order_release);
    slot.start_fraction.store(line.start_fraction, std::memory_order_release);
    slot.before.store(line.before, std::memory_order_release);
    slot.after.store(line.after, std::memory_order_release);
    slot.slowest.store(line.slowest, std::memory_order_release);
    slot.span_cycles.store(line.span_cycles, std::memory_order_release);
    newest_.store(number, std::memory_order_release);
  }

  Nanoseconds read() const noexcept {
    for (;;) {
      const std::uint32_t number = newest_.load(std::memory_order_acquire);
      const Slot& slot = slots_[number % kSlots];
      ClockLine line;
      line.start_cycles = slot.start_cycles.load(std::memory_order_acquire);
      line.start_ns = slot.start_ns.load(std::memory_order_acquire);
      line.start_fraction = slot.start_fraction.load(std::memory_order_acquire);
      line.before = slot.before.load(std::memory_order_acquire);
      line.after = slot.after.load(std::memory_order_acquire);
      line.slowest = slot.slowest.load(std::memory_order_acquire);
      line.span_cycles = slot.span_cycles.load(std::memory_order_acquire);
      const std::uint64_t cycles = read_cycles();
      if (newest_.load(std::memory_order_relaxed) - number < kSlots - 1) [[likely]]
        return line.at(cycles);
    }
  }

 private:
  struct alignas(64) Slot {
    std::atomic<std::uint64_t> start_cycles;
    std::atomic<std::int64_t> start_ns;
    std::atomic<std::uint64_t> start_fraction;
    std::atomic<std::int64_t> before;
    std::atomic<std::int64_t> after;
    std::atomic<std::int64_t> slowest;
    std::atomic<std::uint64_t> span_cycles;
  };
  Slot slots_[kSlots]{};
  alignas(64) std::atomic<std::uint32_t> newest_{0};  ///< 0: there is no line yet
};

extern ClockLineCell fast_clock_cell;
#endif

}  // namespace detail

/// CLOCK_MONOTONIC [ns], to within 1 us (see anchor_fast_clock). About 11 ns on a virtual x86-64 where
/// clock_gettime takes 21; no system call, no lock.
inline Nanoseconds fast_now() noexcept {
#if SORTIE_CYCLE_COUNTER
  if (!detail::fast_clock_cell.empty()) [[likely]]
    return detail::fast_clock_cell.read();
#endif
  return monotonic_now();
}

}  // namespace sortie::rt::posix
