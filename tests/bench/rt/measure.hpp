// SPDX-License-Identifier: BSD-3-Clause
// What the parts of the real-time benchmark share: settings, and two threads that begin together.
#pragma once

#include <atomic>
#include <cstdint>
#include <latch>
#include <string>
#include <thread>

#include "rt/posix/realtime.hpp"
#include "rt/time.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// How much is measured, and where.
struct Settings {
  int rounds{11};       ///< of each part; a round holds one slice of every peer
  double slice_s{1.0};  ///< of a wake-up slice
  int core{-1};         ///< that the real-time thread is pinned to; the last usable one unless asked for
  int other_core{-1};   ///< of the second thread, -1 where there is but one core
  int load{0};          ///< busy ordinary processes beside the wake-up slices
  bool realtime{};      ///< SCHED_FIFO was granted
  std::string program;  ///< own path
};

/// Tells on stderr what is being measured.
void say(const std::string& words);

/// Puts the calling thread on `core` and, where it was granted, on SCHED_FIFO; back to ordinary at the end.
class RealtimeSlice {
 public:
  RealtimeSlice(const Settings& settings, int core, int priority);
  ~RealtimeSlice();
  RealtimeSlice(const RealtimeSlice&) = delete;
  RealtimeSlice& operator=(const RealtimeSlice&) = delete;
};

/// Runs `here` on the settings' core and `other` on the other one, real-time, from the same moment on. Both
/// are on their cores before either is real-time: a spinning thread lets nobody else get there.
template <class Here, class Other>
void on_both_cores(const Settings& settings, int priority, Here here, Other other) {
  std::latch placed(2);
  std::atomic<int> ready{0};
  const auto meet = [&](int core) {
    if (core >= 0) static_cast<void>(rt::posix::pin_to_core(core).ok);
    placed.arrive_and_wait();
  };
  const auto start = [&ready] {
    ready.fetch_add(1);
    while (ready.load() < 2) {
    }
  };
  std::thread second([&] {
    meet(settings.other_core);
    const RealtimeSlice slice(settings, settings.other_core, priority);
    start();
    other();
  });
  std::thread first([&] {
    meet(settings.core);
    const RealtimeSlice slice(settings, settings.core, priority);
    start();
    here();
  });
  first.join();
  second.join();
}

// The parts.
Json measure_noise(const Settings& settings);
void measure_wake(const Settings& settings, Report& report);
void measure_queues(const Settings& settings, Report& report);
void measure_queue_instructions(const Settings& settings, Report& report);
void measure_mailboxes(const Settings& settings, Report& report);
void measure_executive(const Settings& settings, Report& report);
void measure_system_calls(const Settings& settings, Report& report);
void measure_causes(const Settings& settings, Report& report);
void measure_load(const Settings& settings, Report& report);
/// The counted child of measure_queue_instructions(): queues under callgrind.
int run_counted_queues();

}  // namespace sortie::bench
