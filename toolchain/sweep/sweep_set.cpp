// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_set.hpp"

#include <algorithm>
#include <cmath>

#include "toolchain/judge/pareto.hpp"

namespace sortie::toolchain {

namespace {

void take_figure(double value, std::size_t before, Spread& spread) {
  const auto n = static_cast<double>(before);
  spread.low = before == 0 ? value : std::min(spread.low, value);
  spread.high = before == 0 ? value : std::max(spread.high, value);
  spread.mean = (spread.mean * n + value) / (n + 1);
}

// In the order in which the combinations appear first.
std::vector<SweepSpread> spread_of(const std::vector<LogSweep>& logs, const std::string& error) {
  std::vector<SweepSpread> all;
  for (const LogSweep& log : logs) {
    for (const SweepCell& cell : log.sweep.cells) {
      auto row = std::find_if(all.begin(), all.end(),
                              [&cell](const SweepSpread& other) { return other.values == cell.values; });
      if (row == all.end()) {
        row = all.insert(all.end(), SweepSpread{});
        row->values = cell.values;
        row->profile_choice = true;
      }
      row->profile_choice = row->profile_choice && cell.profile_choice;
      const auto found = cell.errors.find(error);
      if (found == cell.errors.end() || !std::isfinite(found->second)) continue;
      take_figure(found->second, row->logs, row->error);
      take_figure(cell.load_us_per_s, row->logs, row->load_us_per_s);
      ++row->logs;
    }
  }
  std::vector<CostAndError> points;
  for (const SweepSpread& row : all) {
    // What some logs do not give cannot be set beside what all give.
    points.push_back({row.load_us_per_s.mean, row.logs == logs.size() ? row.error.mean : std::nan("")});
  }
  const std::vector<bool> front = measured_front(std::move(points));
  for (std::size_t i = 0; i < all.size(); ++i) all[i].on_front = front[i];
  return all;
}

}  // namespace

SweepSet make_sweep_set(std::vector<LogSweep> logs) {
  SweepSet set;
  set.logs = std::move(logs);
  if (set.logs.empty()) return set;
  set.error = set.logs.front().sweep.error;
  if (set.logs.size() == 1) return set;
  for (const LogSweep& log : set.logs) {
    if (log.sweep.keys == set.logs.front().sweep.keys) continue;
    set.error.clear();  // each knob alone: they have nothing in common
    return set;
  }
  for (const LogSweep& log : set.logs) {
    if (log.sweep.error == set.error) continue;
    set.warnings.push_back("the logs are not judged by the same error (" + set.error + ", " +
                           log.sweep.error + "), so there is no spread; choose one with --error");
    set.error.clear();
    return set;
  }
  if (!set.error.empty()) set.spread = spread_of(set.logs, set.error);
  return set;
}

SweepSet gather_sweep(const SweepFolderPlan& plan, const std::vector<std::string>& folders,
                      std::vector<std::size_t>& missing) {
  std::vector<LogSweep> logs;
  std::vector<std::vector<std::optional<MapVolume>>> maps;
  for (const PlannedLog& log : plan.logs) {
    logs.push_back({log.path, log.plan.sweep});
    maps.emplace_back(log.plan.sweep.cells.size());
  }
  missing.clear();
  for (std::size_t number = 0; number < plan.cell_count(); ++number) {
    std::optional<SweepCellResult> result;
    for (const std::string& folder : folders) {
      if (!result) result = read_cell(folder, number, plan);
    }
    if (!result) {
      missing.push_back(number);
      continue;
    }
    const auto [l, c] = plan.locate(number);
    logs[l].sweep.duration_s = result->duration_s;
    logs[l].sweep.cells[c] = std::move(result->cell);
    maps[l][c] = std::move(result->map);
  }
  if (!missing.empty()) return {};
  for (std::size_t l = 0; l < logs.size(); ++l) judge_sweep(maps[l], logs[l].sweep);
  return make_sweep_set(std::move(logs));
}

}  // namespace sortie::toolchain
