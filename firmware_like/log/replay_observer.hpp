// SPDX-License-Identifier: BSD-3-Clause
// What a replay keeps of its jobs while they run.
#pragma once

#include <mutex>
#include <optional>
#include <utility>

#include "firmware_like/log/compare.hpp"
#include "firmware_like/log/log_feed.hpp"
#include "firmware_like/log/recorded_times.hpp"
#include "firmware_like/log/replay.hpp"
#include "firmware_like/runtime/chain_watch.hpp"

namespace sortie::firmware {

/// Follows the jobs of a replay: poses for the errors and differences for the check, which go into its
/// outcome, and the live run's times for the gate.
class ReplayObserver {
 public:
  /// `all_in_time`: the log was made where no job can miss.
  ReplayObserver(ReplayOutcome& outcome, const LogFeed& feed, const ReplayOptions& options,
                 rt::Tick first_tick, bool all_in_time, RecordedTimes recorded)
      : chains(*outcome.runtime, false),
        times(std::move(recorded)),
        outcome_(outcome),
        runtime_(*outcome.runtime),
        feed_(feed),
        options_(options),
        first_tick_(first_tick),
        all_in_time_(all_in_time) {}

  /// After a job, on the thread that ran it.
  void job(const rt::JobRecord& record) {
    const std::lock_guard lock(mutex_);  // replays may run one worker a group
    const JobTimes* const live = times.find(record);
    chains.job(record, live);
    if (record.tick >= first_tick_) times.count(record, live);
    if (record.tick < first_tick_) {
      // On the way from a keyframe to the place that was asked for.
    } else if (const auto* pose = runtime_.vehicle().pose_task();
               pose != nullptr && pose->group() == record.group) {
      keep(to_timed_pose(pose->value()), outcome_.estimate);
    } else if (const auto* attitude = runtime_.vehicle().attitude_task();
               pose == nullptr && attitude != nullptr && attitude->group() == record.group) {
      TimedPose only_turned;
      only_turned.stamp_ns = attitude->value().stamp_ns;
      for (int i = 0; i < 4; ++i) only_turned.q[i] = attitude->value().q_world_body[i];
      only_turned.flags = rt::kTruthOrientation;
      keep(only_turned, outcome_.estimate);
    }
    if (const auto* located_task = runtime_.vehicle().located_task();
        record.tick >= first_tick_ && located_task != nullptr && located_task->group() == record.group)
      keep(to_timed_pose(located_task->value()), outcome_.located);
    if (const rt::JobRecord* recorded = feed_.recorded(record.group); recorded != nullptr) {
      ++outcome_.compared_jobs;
      if (auto divergence = compare(*recorded, record, live)) {
        ++outcome_.diverged_jobs;
        // The lowest tick, then the order of the table: threads of other groups may come here first.
        std::optional<Divergence>& first = outcome_.divergence;
        if (!first || divergence->tick < first->tick ||
            (divergence->tick == first->tick && record.group < first_group_)) {
          first = std::move(divergence);
          first_group_ = record.group;
        }
      }
    }
    if (options_.on_job) options_.on_job(record, runtime_);
  }

  ChainWatch chains;
  RecordedTimes times;

 private:
  // What was taken and decided comes before what followed from it.
  std::optional<Divergence> compare(const rt::JobRecord& recorded, const rt::JobRecord& record,
                                    const JobTimes* live) const {
    const rt::Executive& executive = runtime_.executive();
    std::optional<Divergence> found = compare_decisions(executive, recorded, record);
    if (!found) found = compare_outputs(executive, recorded, record);
    if (!found && live != nullptr) found = compare_with_times(executive, recorded, *live);
    if (!found && all_in_time_ && recorded.verdict != rt::Verdict::done)
      found = wrong_verdict(executive, recorded, "done: nothing is late in simulated time");
    return found;
  }

  static void keep(const TimedPose& pose, Trajectory& path) {
    if (pose.stamp_ns == 0 || (!path.empty() && path.back().stamp_ns == pose.stamp_ns)) return;
    path.push_back(pose);
  }

  ReplayOutcome& outcome_;
  Runtime& runtime_;
  const LogFeed& feed_;
  const ReplayOptions& options_;
  rt::Tick first_tick_;
  bool all_in_time_;
  std::uint16_t first_group_{};
  std::mutex mutex_;
};

}  // namespace sortie::firmware
