// SPDX-License-Identifier: BSD-3-Clause
// Measures all chains of a runtime during a run.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "firmware_like/runtime/chain_meter.hpp"
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

/// A chain that was measured above what its profile allows.
struct ChainNews {
  std::string chain;
  std::string text;  ///< what was measured, what is allowed, how often so far
};

/// One meter a chain. Fed with every job's record, off the real-time path, by one thread at a time.
///
/// The rule of declared bounds: what a profile allows is either computed to hold, or refused at the start
/// with what is missing (read_chains). What is then measured above it is never silent: in simulated time,
/// where nothing can come late by accident, it is a failure; in a live run an event as it happens, a counter
/// (chain_bounds_exceeded) and a warning.
class ChainWatch {
 public:
  /// `on_run_clock`: a live run in real time. Lives no longer than `runtime`.
  ChainWatch(const Runtime& runtime, bool on_run_clock);

  /// `times`: of the live run, where the record is of its replay (ChainMeter::job).
  void job(const rt::JobRecord& record, const JobTimes* times = nullptr) {
    const std::lock_guard lock(mutex_);
    for (const auto& meter : meters_) meter->job(record, times);
  }
  /// Chains that exceeded their bounds since they were last told, each at most once a second. Any thread that
  /// is not real-time.
  std::vector<ChainNews> take_news(rt::Nanoseconds now_ns);
  /// Puts what was measured beside what was computed, in the results of that runtime, whose live times are in
  /// place. A reaction more than a tick beyond its bound becomes a warning if no release was missed, skipped
  /// or shed; so do samples that came too far apart, a declared bound that nothing measured, and one that was
  /// exceeded.
  void add_to(Results& results) const;

 private:
  struct Told {
    std::uint64_t count{};
    rt::Nanoseconds at_ns{};
  };

  std::string excess(std::size_t chain) const;
  std::uint64_t over(std::size_t chain) const;

  const Runtime& runtime_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<ChainMeter>> meters_;  // in the order of the runtime's chains
  std::vector<Told> told_;
};

/// One line for each declared bound that was exceeded; empty: all were kept.
std::vector<std::string> exceeded_bounds(const Results& results);

}  // namespace sortie::firmware
