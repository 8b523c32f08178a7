// SPDX-License-Identifier: BSD-3-Clause
// What the parts of the real-time benchmark share: settings, repetitions, and the JSON that they fill.
#pragma once

#include <atomic>
#include <cstdint>
#include <latch>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "rt/histogram.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/time.hpp"

namespace sortie::bench {

using Json = nlohmann::ordered_json;

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

/// Repetitions of one figure, one a round.
class Rounds {
 public:
  void add(double value) { values_.push_back(value); }
  bool empty() const { return values_.empty(); }
  std::size_t size() const { return values_.size(); }
  const std::vector<double>& values() const { return values_; }
  double median() const;
  double low() const;
  double high() const;
  /// Nearest-rank quantile, 0..1.
  double quantile(double share) const;

 private:
  std::vector<double> values_;
};

/// Round by round, own over theirs.
Rounds ratio(const Rounds& own, const Rounds& theirs);

/// One line of the table: our figure beside a peer's.
struct Figure {       // NOLINT(bugprone-exception-escape): JSON's own move, out of memory at most
  std::string group;  ///< "wake-up", "queue", ...
  std::string what;   ///< e.g. "round trip p50"
  std::string unit;
  std::uint64_t n{};  ///< samples behind it
  Json ours;          ///< {value, low, high}: median and range of the rounds, or the whole run's figure
  std::string peer;   ///< empty: no peer
  Json theirs;
  Json ratio;        ///< {value, low, high}
  std::string goal;  ///< in words, empty: none
  Json met;          ///< true, false, or null where there is no goal
};

/// {value, low, high} of rounds; of one number.
Json spread(const Rounds& rounds);
Json spread(double value);

/// What the parts fill.
class Report {  // NOLINT(bugprone-exception-escape)
 public:
  void add(const Figure& figure);
  /// A peer or a part that could not run: what, why, and the cure.
  void skip(const std::string& what, const std::string& why);
  /// A line below the table of a group.
  void note(const std::string& group, const std::string& words);
  /// A whole distribution for the plots; durations in ns.
  void add_distribution(const std::string& name, const rt::LatencyHistogram& histogram);
  /// The same in 1-us bins of another program.
  void add_distribution(const std::string& name, const std::vector<std::uint64_t>& bins_us,
                        std::uint64_t max_us);
  Json& root() { return root_; }

 private:
  Json root_;
};

/// "a at most b" in words and as verdict.
void set_goal(Figure& figure, const std::string& words, bool met);

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
