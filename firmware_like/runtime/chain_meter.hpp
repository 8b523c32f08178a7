// SPDX-License-Identifier: BSD-3-Clause
// Measures one chain from the records of jobs: which samples an output knows of, and when it became visible.
#pragma once

#include <deque>
#include <vector>

#include "firmware_like/runtime/arrivals.hpp"
#include "rt/chains.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

/// When a job began, on the run's clock, and how long each task of its group took.
struct JobTimes {
  rt::Nanoseconds started_ns{};
  std::vector<std::int64_t> duration_ns;
};

/// What a profile allows a chain; 0: anything.
struct ChainLimits {
  rt::Nanoseconds reaction_ns{};
  rt::Nanoseconds age_ns{};
};

/// Follows the newest sample from task to task by what the jobs took, so it sees missed, skipped and shed
/// jobs as they were. Off the real-time path; one thread. Cost: about 100 ns a job of the chain's groups.
class ChainMeter {
 public:
  /// `arrivals`: of the stream that the chain begins with, or null if it begins with a task; outlives the
  /// meter. `on_run_clock`: the records' times of execution are on the clock that samples arrive by; the run
  /// goes on in real time, so that an output without news is as old as it looks.
  ChainMeter(const rt::Executive& executive, const rt::Chain& chain, const Arrivals* arrivals,
             bool on_run_clock, ChainLimits limits = {});

  /// Takes the record of a job. Those of one group come in order; groups may come in any order. `times`: of
  /// the live run, where the record is of a replay; null: the record's own.
  void job(const rt::JobRecord& record, const JobTimes* times = nullptr);

  /// Arrival of a sample to the deadline of the first output that knows of it. One entry a sample.
  const rt::LatencyHistogram& reaction() const { return reaction_; }
  /// Age of the newest sample behind an output when the output becomes visible. One entry an output; after
  /// the last sample there are none.
  const rt::LatencyHistogram& age() const { return age_; }
  /// Arrival of a sample to the end of the last task in the first job that knows of it. Only on the run's
  /// clock, the live run's in a replay that was given its times.
  const rt::LatencyHistogram& finished() const { return finished_; }
  /// Samples that took longer, and outputs that were older, than the limits allow.
  std::uint64_t reactions_over() const { return reactions_over_; }
  std::uint64_t ages_over() const { return ages_over_; }
  /// The longest reaction and the oldest output of those; 0: none.
  rt::Nanoseconds reaction_over_ns() const { return reaction_over_ns_; }
  rt::Nanoseconds age_over_ns() const { return age_over_ns_; }
  /// Longest time between two samples.
  rt::Nanoseconds source_interval_ns() const { return source_interval_ns_; }
  /// Samples whose arrival was not known any more, and jobs whose record was lost.
  std::uint64_t unmeasured() const { return unmeasured_; }

 private:
  static constexpr std::int64_t kNothing = -1;

  // What a leg needs of a record.
  struct Note {
    std::uint64_t job{};
    std::int64_t taken{kNothing};  // newest sample of the stream, or newest job of the group before
    std::uint16_t shed{};
    bool done{};
    bool timed{};  // finished_ns is on the clock that samples arrive by
    rt::Nanoseconds finished_ns{};
  };
  struct Known {
    std::int64_t job{kNothing};
    std::int64_t newest{kNothing};
  };
  struct Leg {
    std::deque<Note> waiting;
    std::vector<Known> outputs;        // by job number, the newest of them
    std::int64_t processed{kNothing};  // newest job that went through
    std::int64_t entered{kNothing};    // newest sample that has come in
  };

  Note note_of(const rt::JobRecord& record, std::uint32_t leg, const JobTimes* times) const;
  void hold_age(rt::Nanoseconds age_ns);
  void process(std::uint32_t leg, const Note& note);
  void put_out(std::int64_t newest, const Note& note);
  bool arrival(std::int64_t sample, rt::Nanoseconds& ns) const;

  const rt::Executive& executive_;
  rt::Chain chain_;
  const Arrivals* arrivals_;
  bool on_run_clock_;
  ChainLimits limits_;
  std::vector<Leg> legs_;
  std::vector<std::int64_t> newest_;      // by step: newest sample that the task's output knows of
  std::int64_t seen_{kNothing};           // newest sample that any output knows of
  bool seen_known_{};                     // its arrival is known
  rt::Nanoseconds seen_at_{};             // and is this
  std::vector<rt::Nanoseconds> repeats_;  // when outputs without news since became visible
  rt::LatencyHistogram reaction_;
  rt::LatencyHistogram age_;
  rt::LatencyHistogram finished_;
  rt::Nanoseconds source_interval_ns_{};
  std::uint64_t unmeasured_{};
  std::uint64_t reactions_over_{};
  std::uint64_t ages_over_{};
  rt::Nanoseconds reaction_over_ns_{};
  rt::Nanoseconds age_over_ns_{};
};

}  // namespace sortie::firmware
