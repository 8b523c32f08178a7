// SPDX-License-Identifier: BSD-3-Clause
// One cell of a sweep: a log replayed with one combination of values, once or several times.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rt/histogram.hpp"
#include "toolchain/judge/map_volume.hpp"
#include "toolchain/sweep/shortest_times.hpp"
#include "toolchain/sweep/sweep.hpp"

namespace sortie::toolchain {

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
