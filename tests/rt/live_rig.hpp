// SPDX-License-Identifier: BSD-3-Clause
// One executive on the real clock, and how a test waits for its end.
#pragma once

#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

#include "rt/executive.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/live_runner.hpp"

namespace sortie::rt::posix::test {

/// One executive on the real clock.
struct LiveRig {
  explicit LiveRig(Nanoseconds tick = kNanosecondsPerMillisecond)
      : memory(4u << 20), arena(memory), executive(arena, tick, 0) {}

  /// Of a run that begins `lead` from now, without real-time threads.
  LiveOptions options(Nanoseconds lead = 20 * kNanosecondsPerMillisecond) {
    LiveOptions live;
    live.realtime = false;
    start_ns = monotonic_now() + lead;
    live.start_ns = start_ns;
    executive.set_clock([](void* self) { return monotonic_now() - *static_cast<Nanoseconds*>(self); },
                        &start_ns);
    return live;
  }
  std::vector<std::byte> memory;
  Arena arena;
  Executive executive;
  Nanoseconds start_ns{};
};

/// All events that wait.
inline std::vector<LiveEvent> drain(LiveRunner& runner) {
  std::vector<LiveEvent> events;
  LiveEvent event;
  while (runner.poll_event(event)) events.push_back(event);
  return events;
}

inline void wait_for(LiveRunner& runner) {
  while (!runner.finished()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  runner.join();
}

}  // namespace sortie::rt::posix::test
