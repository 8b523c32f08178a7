// SPDX-License-Identifier: BSD-3-Clause
// Gives the jobs of a replay what the log holds for them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/wire_records.hpp"
#include "firmware_like/log/log_file.hpp"
#include "firmware_like/log/stream_use.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "rt/archive.hpp"
#include "rt/virtual_runner.hpp"

namespace sortie::firmware {

/// The chained digest of every task of a log with ticks, in table order, and over all of them, as a run
/// computes them.
struct LogDigest {
  std::vector<std::uint64_t> tasks;
  std::uint64_t all{};
  std::uint64_t jobs{};
};

/// Feed of a log. A log with ticks replays exactly: each job takes the samples, the other groups' outputs and
/// the verdict that were recorded. An imported log has no ticks: a sample goes to the first release of its
/// group at or after its receipt. `use_ticks` false: treat any log as imported (another scene, other
/// parameters of the schedule).
class LogFeed final : public rt::JobFeed {
 public:
  LogFeed(const LogFile& log, Runtime& runtime, bool use_ticks);

  bool prepare(std::uint32_t group, std::uint64_t job, rt::Tick tick, rt::JobOrder& order) override;

  /// Leaves out everything from `end` on. Before the first tick is run.
  void end_before(rt::Tick end);
  /// How far the log has been taken before the jobs of `tick`, to bytes and back. Reading: the jobs from
  /// `tick` on come next.
  void archive(rt::Archive& archive, rt::Tick tick);

  /// Of a whole log of a live run, those of the run; else of the first and the last job.
  rt::Tick first_tick() const { return first_tick_; }
  rt::Tick last_tick() const { return last_tick_; }
  /// What the log says about the newest prepared job of a group; null without ticks.
  const rt::JobRecord* recorded(std::uint32_t group) const {
    return use_ticks_ ? groups_[group].current.get() : nullptr;
  }
  /// What the log says that the jobs of this feed put out; empty without ticks.
  LogDigest recorded_digest() const;
  /// Empty, or one line: the recorded job that is damaged, and with which the part that is used ends.
  const std::string& damage() const { return damage_; }
  /// Jobs at the end of the log that took outputs of jobs which it does not hold: it was cut off between the
  /// two.
  std::uint64_t jobs_left_out() const { return jobs_left_out_; }
  std::uint64_t missing_samples() const { return missing_samples_; }  ///< named by a job, not in the log
  std::uint64_t damaged_samples() const { return damaged_samples_; }  ///< of another type, or damaged
  std::uint64_t refused_samples() const { return refused_samples_; }  ///< the stream could not take them
  /// What became of the log's samples so far, by input channel of this scene.
  std::vector<StreamUse> stream_use() const;
  /// Channels of samples that no task of this scene consumes.
  const std::vector<std::string>& unused_channels() const { return unused_channels_; }

 private:
  struct PortCursor {
    InputPortBase* port{};
    const std::vector<StoredEvent>* events{};
    std::size_t next{};
    std::uint64_t asked{};  // samples before this one are there or counted as missing, each once
    StreamUse use;
  };
  struct GroupCursor {
    std::vector<PortCursor*> ports;  // in the order of the group's streams
    std::vector<StoredEvent> jobs;
    std::vector<std::int64_t> needs;  // job by job and input by input: newest job of the writer taken so far
    std::int64_t newest{-1};          // number of the last of `jobs`
    rt::Tick first_tick{};            // of the first of `jobs`
    std::size_t next{};
    std::unique_ptr<rt::JobRecord> current;
    bool ready{};  // `current` holds jobs[next]
  };

  rt::Tick most_ticks() const;
  bool read_job(const StoredEvent& event);
  void index_jobs(const LogFile& log);
  void leave_out_orphans();
  void take_run_end(const LogFile& log);
  std::size_t jobs_before(const GroupCursor& cursor, rt::Tick tick) const;
  bool load(GroupCursor& cursor);
  void push(PortCursor& cursor);

  std::string path_;
  Runtime& runtime_;
  bool use_ticks_;
  std::vector<std::unique_ptr<PortCursor>> ports_;
  std::vector<GroupCursor> groups_;
  mutable rt::JobRecord scratch_;
  rt::Tick first_tick_{};
  rt::Tick last_tick_{};
  std::uint64_t missing_samples_{};
  std::uint64_t damaged_samples_{};
  std::uint64_t refused_samples_{};
  std::uint64_t jobs_left_out_{};
  std::string damage_;
  std::vector<std::string> unused_channels_;
};

}  // namespace sortie::firmware
