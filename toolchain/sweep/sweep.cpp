// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep.hpp"

#include "toolchain/sweep/sweep_plan.hpp"
#include "toolchain/sweep/sweep_work.hpp"

namespace sortie::toolchain {

Sweep run_sweep(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                const SweepOptions& options) {
  SweepPlan plan = plan_sweep(log, vehicles, options);
  Sweep sweep = std::move(plan.sweep);
  std::vector<SweepWork> works;
  for (std::vector<std::string>& overrides : plan.overrides)
    works.emplace_back(std::move(overrides), sweep.tasks);
  const double runs = static_cast<double>(sweep.repeat) * static_cast<double>(works.size());
  double done = 0;
  for (std::uint32_t round = 0; round < sweep.repeat; ++round) {
    for (std::size_t i = 0; i < works.size(); ++i) {
      firmware::ReplayOptions replay_options = options.replay;
      if (options.progress)
        replay_options.progress = [&](double share) { options.progress((done + share) / runs); };
      sweep.duration_s =
          works[i].replay_once(log, vehicles, replay_options, options.evaluation, sweep.cells[i]);
      done += 1;
    }
  }
  if (options.progress) options.progress(1);
  std::vector<std::optional<MapVolume>> maps;
  for (std::size_t i = 0; i < works.size(); ++i) {
    works[i].take_times(sweep.duration_s, sweep.cells[i]);
    if (options.instructions)
      works[i].count_instructions(log, options.replay, sweep.duration_s, sweep.cells[i]);
    maps.push_back(works[i].map());
  }
  judge_sweep(maps, sweep);
  return sweep;
}

}  // namespace sortie::toolchain
