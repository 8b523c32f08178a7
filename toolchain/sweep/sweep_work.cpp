// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_work.hpp"

#include <algorithm>
#include <stdexcept>

#include "toolchain/bench/wcet.hpp"
#include "toolchain/sweep/sweep_plan.hpp"

namespace sortie::toolchain {

SweepWork::SweepWork(std::vector<std::string> overrides, const std::vector<std::string>& tasks)
    : overrides_(std::move(overrides)), tasks_(tasks), times_(tasks.size()) {}

void SweepWork::take_outcome(const firmware::ReplayOutcome& outcome, SweepCell& cell) {
  const rt::Executive& executive = outcome.runtime->executive();
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    const auto found = std::find(tasks_.begin(), tasks_.end(), executive.task(i).name());
    if (found == tasks_.end()) continue;
    times_[static_cast<std::size_t>(found - tasks_.begin())].merge(executive.task(i).wall_time());
  }
  if (!cell.digest.empty()) {
    if (cell.digest == outcome.results.digest) return;
    throw std::runtime_error("two replays with " + cell_title(overrides_) + " give different digests, " +
                             cell.digest + " and " + outcome.results.digest +
                             "; a task reads something that is not in the log");
  }
  cell.digest = outcome.results.digest;
  cell.errors = outcome.results.errors;
  cell.memory_bytes = outcome.runtime->memory_bytes();
  for (const firmware::PoolResult& pool : outcome.results.pools) {
    if (pool.name != "voxels") continue;
    cell.voxels = pool.high_water;
    cell.voxels_refused = pool.refused;
  }
  map_ = map_volume(*outcome.runtime);
}

double SweepWork::replay_once(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                              const firmware::ReplayOptions& options, const EvaluationOptions& judging,
                              SweepCell& cell) {
  firmware::ReplayOptions replay_options = options;
  replay_options.overrides = overrides_;
  shortest_.begin_replay(tasks_);
  replay_options.on_job = [this](const rt::JobRecord& record, firmware::Runtime& runtime) {
    shortest_.take(record, runtime);
  };
  firmware::ReplayOutcome outcome = firmware::replay(log, vehicles, replay_options);
  judge(outcome, judging);
  take_outcome(outcome, cell);
  return outcome.results.duration_s;
}

void SweepWork::count_instructions(const firmware::LogFile& log, const firmware::ReplayOptions& options,
                                   double duration_s, SweepCell& cell) const {
  std::uint64_t sum = 0;
  for (const WcetTask& task : measure_wcet({log.path(), options.scene, overrides_, options.maps, ""}).tasks) {
    if (std::find(tasks_.begin(), tasks_.end(), task.name) == tasks_.end()) continue;
    for (const CountedJob& job : task.jobs) sum += job.instructions;
  }
  if (duration_s > 0) cell.instructions_per_s = static_cast<double>(sum) / duration_s;
}

void SweepWork::take_times(double duration_s, SweepCell& cell) const {
  if (duration_s > 0) cell.load_us_per_s = shortest_.total_us() / duration_s;
  cell.timing.clear();
  for (std::size_t t = 0; t < tasks_.size(); ++t) {
    cell.timing.push_back({tasks_[t], times_[t].count(),
                           static_cast<double>(times_[t].percentile(0.5)) * 1e-3,
                           static_cast<double>(times_[t].percentile(0.99)) * 1e-3,
                           static_cast<double>(times_[t].max()) * 1e-3});
  }
}

}  // namespace sortie::toolchain
