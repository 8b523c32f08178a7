// SPDX-License-Identifier: BSD-3-Clause
// One slice of wake-ups at 1 kHz by each method.
#pragma once

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "rt/histogram.hpp"
#include "rt/posix/delay_observer.hpp"
#include "rt/posix/housekeeper.hpp"
#include "rt/posix/spin_margin.hpp"
#include "tests/bench/rt/measure.hpp"

namespace sortie::bench {

/// What a slice, or all of them together, has seen.
struct WakeSamples {
  rt::LatencyHistogram raw;      ///< lateness of each wake-up; a period that was slept through counts as late
  std::uint64_t clean_max_ns{};  ///< of wake-ups that nothing outside the program delayed
  std::uint64_t late[rt::posix::kDelayCauses]{};       ///< wake-ups later than 100 us, by main cause
  rt::Nanoseconds late_ns[rt::posix::kDelayCauses]{};  ///< their lateness, by cause
  double spun_s{};
  double wall_s{};

  void add(const WakeSamples& slice);
};

/// What tells why a wake-up was late: counters of the cores, and a heart that beats above all priorities on
/// another core, as the live runner's supervisor does.
class Witnesses {
 public:
  explicit Witnesses(const Settings& settings);
  ~Witnesses();
  Witnesses(const Witnesses&) = delete;
  Witnesses& operator=(const Witnesses&) = delete;
  rt::posix::DelayOptions options() const { return {100'000, &keeper_.evidence(), &heart_}; }

 private:
  rt::posix::Housekeeper keeper_;
  rt::posix::Heartbeat heart_;
  std::atomic<bool> stop_{false};
  std::thread beating_;
};

/// Ours: the wait that the live runner's workers use, with their margin, which lives on from slice to slice.
void wake_by_sortie(const Settings& settings, const Witnesses& witnesses, rt::posix::SpinMargin& margin,
                    WakeSamples& samples);
/// clock_nanosleep to the release, nothing else.
void wake_by_sleep(const Settings& settings, WakeSamples& samples);

/// cyclictest's histogram of one slice.
struct CyclictestSlice {
  std::vector<std::uint64_t> bins_us;  ///< index is the latency in us, rounded down
  std::uint64_t overflows{};           ///< later than the histogram reaches
  std::uint64_t max_us{};
  std::string problem;  ///< why there is nothing, with the cure; empty: it ran
};
CyclictestSlice run_cyclictest(const Settings& settings);

}  // namespace sortie::bench
