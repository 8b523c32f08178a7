// SPDX-License-Identifier: BSD-3-Clause
// A worker at 1 kHz under its delay observer, and delays whose cause is known because the rig makes them.
#pragma once

#include <pthread.h>
#include <sched.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "rt/posix/clock.hpp"
#include "rt/posix/delay_observer.hpp"
#include "rt/posix/housekeeper.hpp"
#include "rt/posix/realtime.hpp"
#include "tests/rt/cause_result.hpp"
#include "tests/rt/emulated.hpp"

namespace sortie::rt::posix::test {

/// Whether a thread of this process may become a FIFO thread.
inline SetupResult try_fifo() {
  SetupResult result;
  std::thread([&result] { result = set_fifo_priority(90); }).join();
  return result;
}

/// Runs the worker for `seconds` on the highest core that this process may use, everything else on the
/// lowest.
class CauseRig {
 public:
  CauseRig(Injection injection, std::uint32_t seed, double seconds, RigResult& result)
      : injection_(injection),
        seed_(seed),
        result_(result),
        length_ns_(static_cast<Nanoseconds>(seconds * 1e9)) {
    cpu_set_t set;
    sched_getaffinity(0, sizeof(set), &set);
    for (int core = 0; core < CPU_SETSIZE; ++core) {
      if (CPU_ISSET(static_cast<unsigned>(core), &set) == 0) continue;
      if (low_core_ < 0) low_core_ = core;
      core_ = core;
    }
  }

  /// In this process, or, for a pause, in a child that this process stops and continues.
  void run() {
    if (injection_ != Injection::pause) {
      run_here();
      return;
    }
    const pid_t child = fork();
    if (child == 0) {
      run_here();
      _exit(0);
    }
    std::minstd_rand random(seed_);
    const Nanoseconds end = monotonic_now() + length_ns_ - 100 * kNanosecondsPerMillisecond;
    sleep_until(monotonic_now() + 300 * kNanosecondsPerMillisecond);
    while (monotonic_now() < end) {
      const Nanoseconds begin = monotonic_now();
      kill(child, SIGSTOP);
      sleep_until(begin + static_cast<Nanoseconds>(1 + random() % 5) * kNanosecondsPerMillisecond);
      kill(child, SIGCONT);
      result_.inject(begin, monotonic_now());
      sleep_until(monotonic_now() +
                  static_cast<Nanoseconds>(20 + random() % 20) * kNanosecondsPerMillisecond);
    }
    int status = 0;
    waitpid(child, &status, 0);
  }

 private:
  void run_here() {
    static_cast<void>(steps_per_ns());
    static_cast<void>(keeper_.start());
    std::thread heart([this] { beat(); });
    start_ns_ = monotonic_now() + 100 * kNanosecondsPerMillisecond;
    std::thread worker([this] { work(); });
    worker_ = worker.native_handle();
    std::thread injector([this] { inject(); });
    worker.join();
    stop_ = true;
    injector.join();
    heart.join();
    keeper_.stop();
  }

  void beat() {
    static_cast<void>(pin_to_core(low_core_));
    static_cast<void>(set_fifo_priority(95));
    static_cast<void>(heart_.open_for_this_thread());
    Nanoseconds next = monotonic_now();
    while (!stop_) {
      next += kNanosecondsPerMillisecond;
      sleep_until(next);
      const Nanoseconds woke = monotonic_now();
      heart_.beat(next, woke);
      if (woke > next) next += (woke - next) / kNanosecondsPerMillisecond * kNanosecondsPerMillisecond;
    }
  }

  void work() {
    const auto keep = [this](const SetupResult& setup) {
      if (!setup.ok) std::memcpy(result_.refused, setup.reason, sizeof(result_.refused));
    };
    keep(pin_to_core(core_));
    keep(set_fifo_priority(80));
    keep(prefault_stack(std::size_t{128} * 1024));
    static DelayObserver observer_memory;
    DelayObserver& observer = observer_memory;
    keep(observer.open({100'000, &keeper_.evidence(), &heart_}));
    std::uint64_t seen = observer.statistics().outliers;
    std::minstd_rand random(seed_);
    std::uint32_t next_own = 50;
    constexpr Nanoseconds kBudget = 200'000;
    if (result_.refused[0] != '\0') return;
    const auto collect = [&] {
      for (; seen < observer.statistics().outliers && result_.outlier_count < RigResult::kMost; ++seen)
        result_.outliers[result_.outlier_count++] = observer.statistics().last[seen % DelayStatistics::kLast];
    };
    const auto ticks = static_cast<Tick>(length_ns_ / kNanosecondsPerMillisecond);
    for (Tick tick = 0; tick < ticks;) {
      const Nanoseconds release = start_ns_ + static_cast<Nanoseconds>(tick) * kNanosecondsPerMillisecond;
      const Nanoseconds woke = wait_for_release(observer, tick, release, 50'000).woke_ns;
      const auto now_tick = static_cast<Tick>((woke - start_ns_) / kNanosecondsPerMillisecond);
      if (now_tick > tick) {  // whole periods are left out after an overrun
        result_.skipped += static_cast<std::uint32_t>(now_tick - tick);
        tick = now_tick + 1;
        collect();
        continue;
      }
      // A flood of interrupts stretches a job; it shows in one that nearly fills its budget.
      const bool stretches = injection_ == Injection::timers || injection_ == Injection::signals;
      Nanoseconds busy = stretches ? 170'000 : 30'000;
      if (injection_ == Injection::own_work && tick >= next_own) {
        busy = 400'000 + static_cast<Nanoseconds>(random() % 1'500'000);
        next_own = static_cast<std::uint32_t>(tick + 20 + random() % 20);
      }
      const Nanoseconds began = monotonic_now();
      compute(busy);
      const Nanoseconds ended = monotonic_now();
      observer.after_job(tick, woke, ended, kBudget);
      if (busy > kBudget) result_.inject(began, ended);
      ++result_.jobs;
      ++tick;
      collect();
    }
    observer.finish();
    collect();
  }

  // Work of a known length: counted, so that a thread that is interrupted or preempted still does all of it.
  void compute(Nanoseconds length) {
    const auto steps = static_cast<std::int64_t>(static_cast<double>(length) * steps_per_ns());
    volatile std::uint32_t x = 1;
    for (std::int64_t i = 0; i < steps; ++i) x = x * 1664525u + 1013904223u;
  }
  static double steps_per_ns() {
    static const double rate = [] {
      double best = 0;
      for (int k = 0; k < 20; ++k) {
        const Nanoseconds before = monotonic_now();
        volatile std::uint32_t x = 1;
        for (std::int64_t i = 0; i < 20'000; ++i) x = x * 1664525u + 1013904223u;
        const double now = 20'000.0 / static_cast<double>(monotonic_now() - before);
        best = now > best ? now : best;
      }
      return best;
    }();
    return rate;
  }

  void inject();
  void inject_hog();
  void inject_signals();
  void inject_timers();
  void rest();

  Injection injection_;
  std::uint32_t seed_;
  std::minstd_rand dice_{seed_};
  RigResult& result_;
  Nanoseconds length_ns_;
  Nanoseconds start_ns_{};
  int core_{-1};
  int low_core_{-1};
  pthread_t worker_{};
  std::atomic<bool> stop_{false};
  Housekeeper keeper_;
  Heartbeat heart_;
};

inline std::atomic<std::uint32_t> signals_handled{0};
inline void handle_signal(int) { signals_handled.fetch_add(1, std::memory_order_relaxed); }

inline void CauseRig::inject() {
  sleep_until(start_ns_ + 50 * kNanosecondsPerMillisecond);
  if (injection_ == Injection::hog) inject_hog();
  if (injection_ == Injection::signals || injection_ == Injection::queued_signals) inject_signals();
  if (injection_ == Injection::timers) inject_timers();
}

// 20 to 40 ms without any injection.
inline void CauseRig::rest() {
  sleep_until(monotonic_now() + 20 * kNanosecondsPerMillisecond +
              static_cast<Nanoseconds>(dice_() % 20'000'000));
}

inline void CauseRig::inject_hog() {
  static_cast<void>(pin_to_core(core_));
  static_cast<void>(set_fifo_priority(90));
  while (!stop_) {
    rest();
    const Nanoseconds begin = monotonic_now();
    const Nanoseconds end = begin + 300'000 + static_cast<Nanoseconds>(dice_() % 1'500'000);
    while (monotonic_now() < end) {
    }
    result_.inject(begin, monotonic_now());
  }
}

// Each signal after the one before was handled, so that each comes with an interrupt; or all at once.
inline void CauseRig::inject_signals() {
  struct sigaction action {};
  action.sa_handler = handle_signal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGRTMIN, &action, nullptr);
  static_cast<void>(pin_to_core(low_core_));
  static_cast<void>(set_fifo_priority(70));
  while (!stop_) {
    rest();
    const Nanoseconds begin = monotonic_now();
    const std::uint32_t burst = 300 + static_cast<std::uint32_t>(dice_() % 1000);
    const std::uint32_t handled = signals_handled.load();
    const Nanoseconds patience = begin + 50 * kNanosecondsPerMillisecond;
    const auto await = [&](std::uint32_t goal) {
      while (!stop_ && signals_handled.load() < goal && monotonic_now() < patience) {
      }
    };
    for (std::uint32_t i = 0; i < burst && monotonic_now() < patience; ++i) {
      if (pthread_sigqueue(worker_, SIGRTMIN, sigval{}) != 0) break;
      if (injection_ == Injection::signals) await(handled + i + 1);
    }
    await(handled + burst);
    result_.inject(begin, monotonic_now());
  }
}

// Timers of the worker's core that run out one after the other: one interrupt each.
inline void CauseRig::inject_timers() {
  static_cast<void>(pin_to_core(core_));  // a timer's interrupt comes to the core that has set it
  constexpr Nanoseconds kApart = 4'000;
  std::vector<int> timers(900);
  for (int& timer : timers) timer = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC);
  while (!stop_) {
    rest();
    const Nanoseconds begin = monotonic_now() + 4 * kNanosecondsPerMillisecond;
    Nanoseconds at = begin;
    for (const int timer : timers) {
      itimerspec when{};
      when.it_value.tv_sec = static_cast<time_t>(at / kNanosecondsPerSecond);
      when.it_value.tv_nsec = static_cast<decltype(when.it_value.tv_nsec)>(at % kNanosecondsPerSecond);
      timerfd_settime(timer, TFD_TIMER_ABSTIME, &when, nullptr);
      at += kApart;
    }
    sleep_until(at);
    result_.inject(begin, at);
  }
  for (const int timer : timers) close(timer);
}

}  // namespace sortie::rt::posix::test
