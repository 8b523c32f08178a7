// SPDX-License-Identifier: BSD-3-Clause
// One cell of a sweep: a log replayed with one combination of values, once or several times.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware_like/runtime/runtime.hpp"
#include "rt/histogram.hpp"
#include "toolchain/judge/map_volume.hpp"
#include "toolchain/sweep/sweep.hpp"

namespace sortie::toolchain {

/// The run time of every job of the tasks that count, the shortest of all repetitions: each does the same
/// work again, so what it took longer was the machine. Memory: 4 bytes a job and task.
class ShortestTimes {
 public:
  /// Before each replay of the same log with the same profile; `tasks`: names of those that count.
  void begin_replay(const std::vector<std::string>& tasks) {
    tasks_ = tasks;
    shortest_.resize(tasks.size());
    next_.assign(tasks.size(), 0);
    slots_.clear();
  }
  /// Each job of the replay, in its order.
  void take(const rt::JobRecord& record, const firmware::Runtime& runtime) {
    const rt::Executive& executive = runtime.executive();
    if (slots_.empty()) look_up(executive);
    for (std::uint32_t i = 0; i < record.tasks; ++i) {
      const int slot = slots_[record.group][i];
      if (slot < 0) continue;
      const auto task = static_cast<std::size_t>(slot);
      std::vector<std::uint32_t>& times = shortest_[task];
      const std::size_t job = next_[task]++;
      if (job == times.size()) times.push_back(record.duration_ns[i]);
      times[job] = std::min(times[job], record.duration_ns[i]);
    }
  }
  /// Sum over all jobs, us.
  double total_us() const {
    double sum = 0;
    for (const auto& times : shortest_) {
      for (const std::uint32_t ns : times) sum += 1e-3 * ns;
    }
    return sum;
  }

 private:
  void look_up(const rt::Executive& executive) {
    for (std::uint32_t g = 0; g < executive.group_count(); ++g) {
      std::vector<int>& slots = slots_.emplace_back();
      for (const rt::TaskBase* task : executive.group(g).tasks) {
        const auto found = std::find(tasks_.begin(), tasks_.end(), task->name());
        slots.push_back(found == tasks_.end() ? -1 : static_cast<int>(found - tasks_.begin()));
      }
    }
  }

  std::vector<std::string> tasks_;
  std::vector<std::vector<std::uint32_t>> shortest_;
  std::vector<std::size_t> next_;
  std::vector<std::vector<int>> slots_;  // by group and place in it
};

/// What the repetitions of one cell add up to. Memory: 4 bytes a job and task, 8 bytes a voxel.
class SweepWork {
 public:
  /// `tasks`: names of those whose run time counts.
  SweepWork(std::vector<std::string> overrides, const std::vector<std::string>& tasks);

  /// Replays the log once more. Gives the log's duration, s. `cell` takes digest, errors, memory and voxels
  /// of the first replay. Throws as replay() does, and std::runtime_error when a later one has another
  /// digest.
  double replay_once(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                     const firmware::ReplayOptions& options, const EvaluationOptions& judging,
                     SweepCell& cell);
  /// Counts the instructions of the tasks over the whole log. Throws CountRefused
  /// (toolchain/bench/wcet.hpp).
  void count_instructions(const firmware::LogFile& log, const firmware::ReplayOptions& options,
                          double duration_s, SweepCell& cell) const;
  /// Writes the run times of all replays so far into the cell.
  void take_times(double duration_s, SweepCell& cell) const;
  /// The map that the first replay left; nothing where the vehicle has none.
  const std::optional<MapVolume>& map() const { return map_; }

 private:
  void take_outcome(const firmware::ReplayOutcome& outcome, SweepCell& cell);

  std::vector<std::string> overrides_;
  std::vector<std::string> tasks_;
  std::vector<rt::LatencyHistogram> times_;  // one a task
  ShortestTimes shortest_;
  std::optional<MapVolume> map_;
};

}  // namespace sortie::toolchain
