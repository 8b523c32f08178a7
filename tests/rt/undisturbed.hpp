// SPDX-License-Identifier: BSD-3-Clause
// For tests of the real clock whose premise is that the machine is there: the premise is measured beside
// them.
#pragma once

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

namespace sortie::testing {

/// Notes the longest time that this process was given no processor, as a thread of its own sees it: it sleeps
/// for a millisecond at a time and looks how long that took.
class PauseWitness {
 public:
  PauseWitness() : thread_([this] { watch(); }) {}
  ~PauseWitness() { stop(); }
  PauseWitness(const PauseWitness&) = delete;
  PauseWitness& operator=(const PauseWitness&) = delete;

  /// Ends the watch.
  std::chrono::nanoseconds longest() {
    stop();
    return longest_;
  }

 private:
  using Clock = std::chrono::steady_clock;

  void stop() {
    ended_.store(true);
    if (thread_.joinable()) thread_.join();
  }
  void watch() {
    Clock::time_point before = Clock::now();
    for (bool last = false; !last;) {
      last = ended_.load();  // one more look after the end
      if (!last) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const Clock::time_point now = Clock::now();
      longest_ = std::max<std::chrono::nanoseconds>(longest_, now - before);
      before = now;
    }
  }

  std::atomic<bool> ended_{false};
  std::chrono::nanoseconds longest_{};
  std::thread thread_;  // last: it uses all of the above
};

/// The outcome of the first of up to twenty trials during which the machine never went away for `limit`; of
/// the last, with a warning, if there is none. A trial only gathers; what it gathered is checked afterwards.
template <class Trial>
auto undisturbed(std::chrono::milliseconds limit, Trial trial) {
  for (int attempt = 1;; ++attempt) {
    PauseWitness witness;
    auto outcome = trial();
    const std::chrono::nanoseconds longest = witness.longest();
    if (longest < limit) return outcome;
    if (attempt == 20) {
      WARN("this machine went away for " << longest.count() / 1'000'000 << " ms in the last of " << attempt
                                         << " trials");
      return outcome;
    }
  }
}

}  // namespace sortie::testing
