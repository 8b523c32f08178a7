// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include "firmware_like/bench/job_times.hpp"
#include "firmware_like/bench/map_volume.hpp"
#include "firmware_like/bench/pareto.hpp"

namespace sortie::firmware {

namespace {

using Tasks = std::vector<std::string>;

// Run times of the same work differ by so much from one replay to the next.
constexpr double kSameCost = 0.05;
// What no truth is good enough to tell apart.
constexpr double kSameError = 0.001;

// What the repetitions of one cell add up to.
struct Work {
  std::vector<std::string> overrides;
  std::vector<rt::LatencyHistogram> times;  // one a task
  JobTimes shortest;
  std::optional<MapVolume> map;
};

std::string name_of(const std::vector<std::string>& overrides) {
  std::string name;
  for (const std::string& text : overrides) name += (name.empty() ? "" : " ") + text;
  return name.empty() ? "the profile's own values" : name;
}

std::unique_ptr<Runtime> build(const LogFile& log, const VehicleRegistry& vehicles,
                               const SweepOptions& options, const std::vector<std::string>& overrides) {
  const drivers::LogHeader& header = log.header();
  if (options.replay.scene.empty() && header.scene_toml.empty()) {
    throw ProfileError(log.path() +
                       " was imported and names no scene; add --scene NAME (`sortie scenes` lists them)");
  }
  try {
    Profile profile = options.replay.scene.empty()
                          ? Profile(header.scene_toml, log.path() + " (profile)", overrides)
                          : load_scene(options.replay.scene, overrides);
    return std::make_unique<Runtime>(std::move(profile), vehicles, RuntimeStart{});
  } catch (const ProfileError& error) {
    throw ProfileError("with " + name_of(overrides) + ": " + error.what());
  }
}

std::string value_of(const Runtime& runtime, const std::string& key) {
  for (const ProfileKey& known : runtime.profile().keys()) {
    if (known.path == key) return known.value;
  }
  throw ProfileError("--sweep " + key + "=...: scene " + runtime.profile().name() +
                     " does not read this key; see `sortie scenes --keys`");
}

Tasks choose_tasks(const SweepOptions& options, const Runtime& runtime) {
  Tasks wanted = options.tasks;
  for (const SweepKnob& knob : options.knobs) {
    if (!options.tasks.empty()) break;
    for (std::string& name : tasks_of_knob(knob.key, runtime)) wanted.push_back(std::move(name));
  }
  Tasks chosen;  // in the order of the table
  std::string known;
  for (std::uint32_t i = 0; i < runtime.executive().task_count(); ++i) {
    const std::string name = runtime.executive().task(i).name();
    known += (known.empty() ? "" : ", ") + name;
    if (std::find(wanted.begin(), wanted.end(), name) != wanted.end()) chosen.push_back(name);
  }
  for (const std::string& name : wanted) {
    if (std::find(chosen.begin(), chosen.end(), name) == chosen.end())
      throw ProfileError("--task " + name + ": scene " + runtime.profile().name() +
                         " has no such task; it has: " + known);
  }
  return chosen;
}

// Knobs of the map are judged by the map, those of the attitude by the inclination, all others by the way.
std::string choose_error(const SweepOptions& options, const std::vector<SweepCell>& cells) {
  std::map<std::string, double> known;
  for (const SweepCell& cell : cells) known.insert(cell.errors.begin(), cell.errors.end());
  if (!options.error.empty()) {
    if (known.count(options.error) != 0) return options.error;
    std::string names;
    for (const auto& [name, unused] : known) names += (names.empty() ? "" : ", ") + name;
    throw ProfileError("--error " + options.error + ": this log and scene give no such error; they give: " +
                       (names.empty() ? "none" : names));
  }
  std::vector<std::string> order;
  for (const SweepKnob& knob : options.knobs) {
    if (knob.key.rfind("map.", 0) == 0 || knob.key == "limits.voxels") order.push_back("map_disagreement");
    if (knob.key.rfind("attitude.", 0) == 0) order.push_back("inclination_rmse_deg");
  }
  for (const char* name : {"ate_rmse_m", "inclination_rmse_deg", "map_disagreement"}) order.push_back(name);
  for (const std::string& name : order) {
    if (known.count(name) != 0) return name;
  }
  return {};
}

void take_outcome(const ReplayOutcome& outcome, const Tasks& tasks, Work& work, SweepCell& cell) {
  const rt::Executive& executive = outcome.runtime->executive();
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    const auto found = std::find(tasks.begin(), tasks.end(), executive.task(i).name());
    if (found == tasks.end()) continue;
    work.times[static_cast<std::size_t>(found - tasks.begin())].merge(executive.task(i).wall_time());
  }
  if (!cell.digest.empty()) {
    if (cell.digest == outcome.results.digest) return;
    throw std::runtime_error("two replays with " + name_of(work.overrides) + " give different digests, " +
                             cell.digest + " and " + outcome.results.digest +
                             "; a task reads something that is not in the log");
  }
  cell.digest = outcome.results.digest;
  cell.errors = outcome.results.errors;
  cell.memory_bytes = outcome.runtime->memory_bytes();
  for (const PoolResult& pool : outcome.results.pools) {
    if (pool.name != "voxels") continue;
    cell.voxels = pool.high_water;
    cell.voxels_refused = pool.refused;
  }
  work.map = map_volume(*outcome.runtime);
}

// There is no true map: the finest one of the sweep stands in for it; of several, the one that holds most.
void judge_maps(std::vector<Work>& works, Sweep& sweep) {
  const MapVolume* reference = nullptr;
  for (const Work& work : works) {
    if (!work.map) continue;
    if (reference == nullptr || work.map->voxel_m < reference->voxel_m ||
        (work.map->voxel_m == reference->voxel_m && work.map->cells.size() > reference->cells.size())) {
      reference = &*work.map;
    }
  }
  if (reference == nullptr) return;
  if (reference->refused != 0) {
    sweep.warnings.push_back("the finest map, by which the others are judged, refused " +
                             std::to_string(reference->refused) + " points; raise limits.voxels with --set");
  }
  for (std::size_t i = 0; i < works.size(); ++i) {
    if (!works[i].map) continue;
    const MapAgreement agreement = compare_volumes(*works[i].map, *reference);
    sweep.cells[i].errors["map_disagreement"] = agreement.disagreement;
    sweep.cells[i].errors["map_missed"] = agreement.missed;
    sweep.cells[i].errors["map_excess"] = agreement.excess;
  }
}

void mark_front(Sweep& sweep) {
  if (sweep.error.empty()) return;
  std::vector<CostAndError> points;
  for (const SweepCell& cell : sweep.cells) {
    const auto error = cell.errors.find(sweep.error);
    points.push_back({cell.load_us_per_s, error != cell.errors.end() ? error->second : std::nan("")});
  }
  merge_close(points, &CostAndError::cost, kSameCost);
  merge_close(points, &CostAndError::error, kSameError);
  const std::vector<bool> front = pareto_front(points);
  for (std::size_t i = 0; i < front.size(); ++i) sweep.cells[i].on_front = front[i];
}

// Grid cells in order, then the profile's own choice if the grid does not hold it.
void lay_cells(const SweepOptions& options, const Runtime& own, Sweep& sweep, std::vector<Work>& works) {
  std::vector<std::string> own_values;
  for (const SweepKnob& knob : options.knobs) own_values.push_back(value_of(own, knob.key));
  bool has_own = false;
  for (std::vector<std::string>& values : span_grid(options.knobs)) {
    Work work;
    work.overrides = options.replay.overrides;
    bool is_own = true;
    for (std::size_t i = 0; i < values.size(); ++i) {
      work.overrides.push_back(options.knobs[i].key + "=" + values[i]);
      is_own = is_own && same_value(values[i], own_values[i]);
    }
    has_own = has_own || is_own;
    SweepCell cell;
    cell.values = std::move(values);
    cell.profile_choice = is_own;
    sweep.cells.push_back(std::move(cell));
    works.push_back(std::move(work));
  }
  if (has_own) return;
  SweepCell cell;
  cell.values = std::move(own_values);
  cell.profile_choice = true;
  sweep.cells.push_back(std::move(cell));
  works.emplace_back().overrides = options.replay.overrides;
}

}  // namespace

std::vector<std::string> tasks_of_knob(const std::string& key, const Runtime& runtime) {
  const rt::Executive& executive = runtime.executive();
  const auto part = [&key](int which) {
    std::size_t from = 0;
    for (; which > 0 && from != std::string::npos; --which) from = key.find('.', from) + 1;
    return key.substr(from, key.find('.', from) - from);
  };
  const std::string table = part(0);
  const bool of_map = table == "limits" || table == "lidar";
  Tasks all;
  Tasks own;
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    const rt::TaskBase& task = executive.task(i);
    const std::string name = task.name();
    all.push_back(name);
    const bool in_group = table == "groups" && part(1) == executive.group(task.group()).spec.name;
    const bool by_name = table == name || (table == "tasks" && part(1) == name) || (of_map && name == "map");
    if (in_group || by_name) own.push_back(name);
  }
  return own.empty() ? all : own;
}

Sweep run_sweep(const LogFile& log, const VehicleRegistry& vehicles, const SweepOptions& options) {
  Sweep sweep;
  std::vector<Work> works;
  {
    const auto own = build(log, vehicles, options, options.replay.overrides);
    sweep.scene = own->profile().name();
    sweep.tasks = choose_tasks(options, *own);
    lay_cells(options, *own, sweep, works);
  }
  for (const SweepKnob& knob : options.knobs) sweep.keys.push_back(knob.key);
  sweep.repeat = std::max<std::uint32_t>(1, options.repeat);
  for (Work& work : works) {
    build(log, vehicles, options, work.overrides);
    work.times.resize(sweep.tasks.size());
  }
  const double runs = static_cast<double>(sweep.repeat) * static_cast<double>(works.size());
  double done = 0;
  for (std::uint32_t round = 0; round < sweep.repeat; ++round) {
    for (std::size_t i = 0; i < works.size(); ++i) {
      ReplayOptions replay_options = options.replay;
      replay_options.overrides = works[i].overrides;
      if (options.progress)
        replay_options.progress = [&](double share) { options.progress((done + share) / runs); };
      works[i].shortest.begin_replay(sweep.tasks);
      replay_options.on_job = [&work = works[i]](const rt::JobRecord& record, Runtime& runtime) {
        work.shortest.take(record, runtime);
      };
      const ReplayOutcome outcome = replay(log, vehicles, replay_options);
      take_outcome(outcome, sweep.tasks, works[i], sweep.cells[i]);
      sweep.duration_s = outcome.results.duration_s;
      done += 1;
    }
  }
  if (options.progress) options.progress(1);
  for (std::size_t i = 0; i < works.size(); ++i) {
    if (sweep.duration_s > 0) sweep.cells[i].load_us_per_s = works[i].shortest.total_us() / sweep.duration_s;
    for (std::size_t t = 0; t < sweep.tasks.size(); ++t) {
      const rt::LatencyHistogram& times = works[i].times[t];
      sweep.cells[i].timing.push_back(
          {sweep.tasks[t], times.count(), static_cast<double>(times.percentile(0.5)) * 1e-3,
           static_cast<double>(times.percentile(0.99)) * 1e-3, static_cast<double>(times.max()) * 1e-3});
    }
  }
  judge_maps(works, sweep);
  sweep.error = choose_error(options, sweep.cells);
  mark_front(sweep);
  if (sweep.error.empty())
    sweep.warnings.push_back("no truth in the log and no map: there is no error to set against run time");
  return sweep;
}

}  // namespace sortie::firmware
