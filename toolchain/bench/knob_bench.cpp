// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/knob_bench.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <ostream>
#include <string_view>

#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

// A cell differs from the profile's choice where its error does so by this share.
constexpr double kSeenShare = 0.02;

bool is_map(const Knob& knob) { return std::string_view(knob.part) == "map"; }

double error_of(const Sweep& sweep, const SweepCell& cell) {
  const auto found = cell.errors.find(sweep.error);
  return found == cell.errors.end() ? std::nan("") : found->second;
}

const SweepCell* own_cell(const Sweep& sweep) {
  const auto own = std::find_if(sweep.cells.begin(), sweep.cells.end(),
                                [](const SweepCell& cell) { return cell.profile_choice; });
  return own == sweep.cells.end() ? nullptr : &*own;
}

// The slowest of the tasks that count.
SweepTiming timing_of(const SweepCell& cell) {
  SweepTiming most;
  for (const SweepTiming& timing : cell.timing)
    if (timing.p50_us >= most.p50_us) most = timing;
  return most;
}

std::string marks(const SweepCell& cell) {
  return std::string(cell.on_front ? "*" : "") + (cell.profile_choice ? "<" : "");
}

std::string figure_or_dash(double value) {
  return std::isfinite(value) ? firmware::format_short(value) : "-";
}

}  // namespace

std::vector<KnobSweep> sweep_knobs(const KnobSet& set, const firmware::VehicleRegistry& vehicles,
                                   std::uint32_t repeat, const std::function<void(double share)>& progress) {
  const firmware::LogFile log(set.log);
  std::vector<KnobTrial> trials = knob_trials(set.scene, set.overrides, vehicles);
  std::vector<KnobSweep> sweeps;
  const firmware::Profile profile = firmware::load_scene(set.scene, set.overrides);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    SweepOptions options;
    options.replay.scene = set.scene;
    options.replay.overrides = set.overrides;
    for (std::string& without : knob_overrides(trials[i].knob, profile))
      options.replay.overrides.push_back(std::move(without));
    options.evaluation = set.evaluation;
    options.knobs = {{trials[i].knob.key, trials[i].tried}};
    if (is_map(trials[i].knob)) options.error = "map_disagreement";
    options.repeat = repeat;
    if (progress) {
      options.progress = [&, i](double share) {
        progress((static_cast<double>(i) + share) / static_cast<double>(trials.size()));
      };
    }
    Sweep sweep = run_sweep(log, vehicles, options);
    sweeps.push_back({std::move(trials[i]), std::move(sweep)});
  }
  return sweeps;
}

firmware::Json to_json(const std::string& set, const std::vector<KnobSweep>& sweeps) {
  firmware::Json rows = firmware::Json::array();
  for (const KnobSweep& knob : sweeps) {
    for (const SweepCell& cell : knob.sweep.cells) {
      const SweepTiming timing = timing_of(cell);
      firmware::Json errors = firmware::Json::object();
      for (const auto& [name, value] : cell.errors)
        errors[name] = std::isfinite(value) ? firmware::Json(value) : firmware::Json();
      rows.push_back({{"set", set},
                      {"part", knob.trial.knob.part},
                      {"knob", knob.trial.knob.key},
                      {"value", cell.values.front()},
                      {"error", knob.sweep.error},
                      {"errors", std::move(errors)},
                      {"load_us_per_s", cell.load_us_per_s},
                      {"p50_us", timing.p50_us},
                      {"p99_us", timing.p99_us},
                      {"max_us", timing.max_us},
                      {"memory_bytes", cell.memory_bytes},
                      {"front", cell.on_front},
                      {"profile", cell.profile_choice}});
    }
  }
  return rows;
}

std::string knob_table(const std::vector<KnobSweep>& sweeps) {
  std::string text =
      "| knob | range | value | | error | load, us/s | p50 us | p99 us | max us | MB |\n"
      "|---|---|---|---|---:|---:|---:|---:|---:|---:|\n";
  for (const KnobSweep& knob : sweeps) {
    const firmware::ProfileKey& key = knob.trial.declared;
    std::string head = "`" + key.path + "`: " + key.meaning;
    std::string range = key.range + (key.unit.empty() ? "" : " " + key.unit);
    for (const SweepCell& cell : knob.sweep.cells) {
      const SweepTiming timing = timing_of(cell);
      text += "| " + head + " | " + range + " | " + cell.values.front() + " | " + marks(cell) + " | " +
              figure_or_dash(error_of(knob.sweep, cell)) + " " + (head.empty() ? "" : knob.sweep.error) +
              " | " + firmware::format_short(cell.load_us_per_s) + " | " +
              firmware::format_short(timing.p50_us) + " | " + firmware::format_short(timing.p99_us) + " | " +
              firmware::format_short(timing.max_us) + " | " +
              firmware::format_fixed(static_cast<double>(cell.memory_bytes) * 1e-6, 2) + " |\n";
      head.clear();
      range.clear();
    }
  }
  return text;
}

void print_knobs(std::ostream& out, const std::string& set, const std::vector<KnobSweep>& sweeps) {
  char line[200];
  out << set << "\n";
  std::snprintf(line, sizeof(line), "%-30s %14s %-2s %10s %-22s %12s %9s %9s\n", "knob", "value", "", "error",
                "", "load us/s", "p99 us", "MB");
  out << line;
  for (const KnobSweep& knob : sweeps) {
    std::string name = knob.trial.knob.key;
    for (const SweepCell& cell : knob.sweep.cells) {
      std::snprintf(line, sizeof(line), "%-30s %14s %-2s %10s %-22s %12s %9s %9.2f\n", name.c_str(),
                    cell.values.front().c_str(), marks(cell).c_str(),
                    figure_or_dash(error_of(knob.sweep, cell)).c_str(), knob.sweep.error.c_str(),
                    firmware::format_short(cell.load_us_per_s).c_str(),
                    firmware::format_short(timing_of(cell).p99_us).c_str(),
                    static_cast<double>(cell.memory_bytes) * 1e-6);
      out << line;
      name.clear();
    }
  }
  out << "\n";
}

Plot plot_knobs(const std::string& set, const std::vector<KnobSweep>& sweeps) {
  Plot plot;
  plot.title = set + ": each knob alone";
  plot.x = {"run time of the knob's tasks, as a share of the profile's", true};
  plot.y = {"error, as a share of the profile's", true};
  plot.height = 420;
  plot.rules = {{1.0, "", kGrey, true}, {1.0, "", kGrey, false}};
  std::map<std::string, Series> parts;
  for (const KnobSweep& knob : sweeps) {
    const SweepCell* own = own_cell(knob.sweep);
    if (own == nullptr || is_map(knob.trial.knob)) continue;
    const double own_error = error_of(knob.sweep, *own);
    for (const SweepCell& cell : knob.sweep.cells) {
      const double error = error_of(knob.sweep, cell) / own_error;
      const double load = cell.load_us_per_s / own->load_us_per_s;
      if (cell.profile_choice || !(error > 0.0) || !std::isfinite(error) || !(load > 0.0)) continue;
      Series& series = parts[knob.trial.knob.part];
      series.x.push_back(load);
      series.y.push_back(error);
      const std::string key = knob.trial.knob.key;
      const bool is_seen = std::fabs(error - 1.0) > kSeenShare;
      series.labels.push_back(is_seen ? key.substr(key.rfind('.') + 1) + "=" + cell.values.front() : "");
    }
  }
  int colour = 0;
  for (auto& [name, series] : parts) {
    series.name = name;
    series.mark = Mark::dots;
    series.width = 4;
    series.colour = colour++;
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace sortie::toolchain
