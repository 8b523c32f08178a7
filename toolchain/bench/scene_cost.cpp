// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/scene_cost.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "firmware_like/link/telemetry.hpp"
#include "firmware_like/live/live_run.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/log/replay.hpp"
#include "firmware_like/scene/scene_parts.hpp"
#include "toolchain/bench/temporary_log.hpp"
#include "toolchain/bench/wcet.hpp"
#include "toolchain/judge/evaluate.hpp"

namespace sortie::toolchain {

namespace {

using Overrides = std::vector<std::string>;

struct Drive {
  firmware::LiveRunOutcome outcome;
  double us_per_tick{};
};

class Measurement {
 public:
  Measurement(const firmware::VehicleRegistry& vehicles, const firmware::SimulatorFactory& simulator,
              const SceneCostOptions& options)
      : vehicles_(vehicles), simulator_(simulator), options_(options), log_(options.log) {}

  SceneCosts run() {
    firmware::Profile profile = firmware::load_scene(options_.scene, options_.overrides);
    SceneCosts costs;
    costs.scene = profile.name();
    costs.machine = firmware::machine_description();
    const bool simulated = log_.empty();
    if (simulated) {
      if (!simulator_ || simulator_(profile, nullptr) == nullptr)
        throw firmware::ProfileError(costs.scene +
                                     " has no simulated robot: give --log LOG (`sortie import` makes one)");
      log_ = folder_.file("drive.lcm");
      const Drive recorded = drive(options_.overrides, log_);
      costs.recorded_us = recorded.us_per_tick;
      costs.drive_us = drive(options_.overrides, "").us_per_tick;
      if (!recorded.outcome.truth.empty()) end_ = recorded.outcome.truth.back();
    }
    if (simulated && options_.live_s > 0) measure_outlets(costs);
    ticks_ = &costs.ticks;
    costs.whole = replays({});
    const auto parts = firmware::parts_of(profile);
    for (const firmware::ScenePart* part : parts) {
      const auto gone = firmware::with_dependants(*part, parts);
      PartCost& line = costs.without.emplace_back();
      line.part = firmware::joined_names(gone);
      line.what = part->what;
      line.is_outlet = line.part == "recorder" || line.part == "telemetry";
      try {
        const Overrides without = firmware::overrides_without(gone);
        // First by itself: what cannot be left out is told with the place in the scene's own file.
        Overrides all = options_.overrides;
        all.insert(all.end(), without.begin(), without.end());
        const firmware::Runtime own(firmware::load_scene(options_.scene, all), vehicles_,
                                    firmware::RuntimeStart{});
        if (line.is_outlet) {
          line.cost = costs.whole;
          line.cost.bytes = own.memory_bytes() + outlet_bytes(own);
        } else {
          line.cost = replays(without);
          if (simulated) drive_without(without, line.cost);
        }
      } catch (const firmware::ProfileError& error) {
        line.refused = error.what();
      }
    }
    add_outlets(costs);
    return costs;
  }

 private:
  Drive drive(const Overrides& overrides, const std::string& record) const {
    firmware::LiveRunOptions run;
    run.scene = options_.scene;
    run.overrides = overrides;
    run.seconds = options_.seconds;
    run.virtual_time = true;
    run.lcm_url = "none";
    run.record = record;
    const auto begin = std::chrono::steady_clock::now();
    Drive drive{firmware::run_live(vehicles_, simulator_, run)};
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
    drive.us_per_tick =
        took.count() / static_cast<double>(std::max<std::uint64_t>(drive.outcome.results.ticks, 1));
    return drive;
  }

  static std::uint64_t outlet_bytes(const firmware::Runtime& runtime) {
    return firmware::LogRecorder::bytes_for(runtime, runtime.outlets().recorder) +
           (runtime.outlets().telemetry ? firmware::Telemetry::bytes() : 0);
  }

  // A live drive on ordinary threads: what those of recorder and telemetry took.
  void measure_outlets(SceneCosts& costs) const {
    firmware::LiveRunOptions run;
    run.scene = options_.scene;
    run.overrides = options_.overrides;
    run.seconds = options_.live_s;
    run.realtime = false;
    run.lcm_url = options_.lcm_url;
    run.record = folder_.file("live.lcm");
    const firmware::LiveRunOutcome outcome = firmware::run_live(vehicles_, simulator_, run);
    const auto per_tick = [&outcome](const char* counter) {
      const auto found = outcome.results.counters.find(counter);
      const auto us = found == outcome.results.counters.end() ? 0 : found->second;
      return static_cast<double>(us) / static_cast<double>(std::max<std::uint64_t>(outcome.results.ticks, 1));
    };
    costs.has_live = true;
    costs.recorder_us = per_tick("recorder_cpu_us");
    costs.telemetry_us = per_tick("telemetry_cpu_us");
  }

  // Every variant but the one without it has the outlet's time as well.
  static void add_outlets(SceneCosts& costs) {
    const auto add = [&costs](SceneCost& cost, std::string_view left_out) {
      for (double* us : {&cost.us_per_tick, &cost.least_us, &cost.most_us})
        *us += (left_out == "recorder" ? 0 : costs.recorder_us) +
               (left_out == "telemetry" ? 0 : costs.telemetry_us);
    };
    add(costs.whole, "");
    for (PartCost& line : costs.without) add(line.cost, line.part);
  }

  void drive_without(const Overrides& without, SceneCost& cost) const {
    Overrides all = options_.overrides;
    all.insert(all.end(), without.begin(), without.end());
    firmware::LiveRunOutcome outcome = drive(all, "").outcome;
    judge(outcome);
    cost.driven = outcome.results.errors;
    if (outcome.truth.empty()) return;
    const double* p = outcome.truth.back().p;
    cost.end_off_m = std::hypot(p[0] - end_.p[0], p[1] - end_.p[1], p[2] - end_.p[2]);
  }

  // The same inputs again, by the profile that stands in the log where a drive was made.
  SceneCost replays(const Overrides& without) const {
    firmware::ReplayOptions replay_options;
    replay_options.overrides = without;
    if (!options_.log.empty()) {
      replay_options.scene = options_.scene;
      replay_options.overrides.insert(replay_options.overrides.begin(), options_.overrides.begin(),
                                      options_.overrides.end());
    }
    SceneCost cost;
    std::vector<double> times;
    const firmware::LogFile log(log_);
    for (unsigned i = 0; i < std::max(options_.runs, 1u); ++i) {
      firmware::ReplayOutcome outcome = firmware::replay(log, vehicles_, replay_options);
      judge(outcome);
      const rt::Executive& executive = outcome.runtime->executive();
      double ns = 0;
      for (std::uint32_t t = 0; t < executive.task_count(); ++t)
        ns += static_cast<double>(executive.task(t).wall_time().sum());
      times.push_back(1e-3 * ns / static_cast<double>(std::max<std::uint64_t>(outcome.results.ticks, 1)));
      cost.bytes = outcome.runtime->memory_bytes() + outlet_bytes(*outcome.runtime);
      cost.errors = outcome.results.errors;
      if (without.empty()) *ticks_ = outcome.results.ticks;
    }
    std::sort(times.begin(), times.end());
    cost.least_us = times.front();
    cost.us_per_tick = times[times.size() / 2];
    cost.most_us = times.back();
    if (options_.instructions) {
      std::uint64_t sum = 0;
      for (const WcetTask& task :
           measure_wcet({log_, replay_options.scene, replay_options.overrides, {}, ""}).tasks) {
        for (const CountedJob& job : task.jobs) sum += job.instructions;
      }
      cost.instructions_per_tick =
          static_cast<double>(sum) / static_cast<double>(std::max<std::uint64_t>(*ticks_, 1));
    }
    return cost;
  }

  const firmware::VehicleRegistry& vehicles_;
  const firmware::SimulatorFactory& simulator_;
  const SceneCostOptions& options_;
  TemporaryFolder folder_;
  std::string log_;
  firmware::TimedPose end_{};
  std::uint64_t* ticks_{};
};

}  // namespace

SceneCosts measure_scene_cost(const firmware::VehicleRegistry& vehicles,
                              const firmware::SimulatorFactory& simulator, const SceneCostOptions& options) {
  return Measurement(vehicles, simulator, options).run();
}

}  // namespace sortie::toolchain
