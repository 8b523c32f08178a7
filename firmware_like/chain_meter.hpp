// SPDX-License-Identifier: BSD-3-Clause
// Measures one chain from the records of a run's jobs: which samples an output knows of, and when it became
// visible.
#pragma once

#include <deque>
#include <vector>

#include "firmware_like/arrivals.hpp"
#include "rt/chains.hpp"
#include "rt/executive.hpp"

namespace sortie::firmware {

/// Follows the newest sample from task to task by what the jobs took, so it sees missed, skipped and shed
/// jobs as they were. Off the real-time path; one thread. Cost: about 100 ns a job of the chain's groups.
class ChainMeter {
 public:
  /// `arrivals`: of the stream that the chain begins with, or null if it begins with a task; outlives the
  /// meter. `on_run_clock`: the records' times of execution are on the clock that samples arrive by.
  ChainMeter(const rt::Executive& executive, const rt::Chain& chain, const Arrivals* arrivals,
             bool on_run_clock);

  /// Takes the record of a job. Those of one group come in order; groups may come in any order.
  void job(const rt::JobRecord& record);

  /// Arrival of a sample to the deadline of the first output that knows of it. One entry a sample.
  const rt::LatencyHistogram& reaction() const { return reaction_; }
  /// Age of the newest sample behind an output when the output becomes visible. One entry an output; after
  /// the last sample there are none.
  const rt::LatencyHistogram& age() const { return age_; }
  /// Arrival of a sample to the end of the last task in the first job that knows of it. Only on the run's
  /// clock.
  const rt::LatencyHistogram& finished() const { return finished_; }
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

  Note note_of(const rt::JobRecord& record, std::uint32_t leg) const;
  void process(std::uint32_t leg, const Note& note);
  void put_out(std::int64_t newest, const Note& note);
  bool arrival(std::int64_t sample, rt::Nanoseconds& ns) const;

  const rt::Executive& executive_;
  rt::Chain chain_;
  const Arrivals* arrivals_;
  bool on_run_clock_;
  std::vector<Leg> legs_;
  std::vector<std::int64_t> newest_;      // by step: newest sample that the task's output knows of
  std::int64_t seen_{kNothing};           // newest sample that any output knows of
  rt::Nanoseconds seen_at_{};             // its arrival
  std::vector<rt::Nanoseconds> repeats_;  // when outputs without news since became visible
  rt::LatencyHistogram reaction_;
  rt::LatencyHistogram age_;
  rt::LatencyHistogram finished_;
  rt::Nanoseconds source_interval_ns_{};
  std::uint64_t unmeasured_{};
};

}  // namespace sortie::firmware
