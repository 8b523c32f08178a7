// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <map>

#include "toolchain/judge/map_volume.hpp"
#include "toolchain/judge/pareto.hpp"
#include "toolchain/sweep/sweep.hpp"

namespace sortie::toolchain {

namespace {

// Knobs of the map are judged by the map, those of the attitude by the inclination, those of the place on a
// map by the located way, all others by the odometry's.
std::string choose_error(const Sweep& sweep) {
  std::map<std::string, double> known;
  for (const SweepCell& cell : sweep.cells) known.insert(cell.errors.begin(), cell.errors.end());
  if (!sweep.error.empty()) {
    if (known.count(sweep.error) != 0) return sweep.error;
    std::string names;
    for (const auto& [name, unused] : known) names += (names.empty() ? "" : ", ") + name;
    throw firmware::ProfileError(
        "--error " + sweep.error +
        ": this log and scene give no such error; they give: " + (names.empty() ? "none" : names));
  }
  std::vector<std::string> order;
  for (const std::string& key : sweep.keys) {
    if (key.rfind("map.", 0) == 0 || key == "limits.voxels") order.push_back("map_disagreement");
    if (key.rfind("attitude.", 0) == 0) order.push_back("inclination_rmse_deg");
    for (const char* table : {"locate.", "relocate.", "tasks.locate.", "tasks.relocate."}) {
      if (key.rfind(table, 0) == 0) order.push_back("located_ate_rmse_m");
    }
  }
  for (const char* name : {"ate_rmse_m", "inclination_rmse_deg", "map_disagreement"}) order.push_back(name);
  for (const std::string& name : order) {
    if (known.count(name) != 0) return name;
  }
  return {};
}

// There is no true map: the finest one of the sweep stands in for it; of several, the one that holds most.
void judge_maps(const std::vector<std::optional<MapVolume>>& maps, Sweep& sweep) {
  const MapVolume* reference = nullptr;
  for (const std::optional<MapVolume>& map : maps) {
    if (!map) continue;
    if (reference == nullptr || map->voxel_m < reference->voxel_m ||
        (map->voxel_m == reference->voxel_m && map->cells.size() > reference->cells.size())) {
      reference = &*map;
    }
  }
  if (reference == nullptr) return;
  if (reference->refused != 0) {
    sweep.warnings.push_back("the finest map, by which the others are judged, refused " +
                             std::to_string(reference->refused) + " points; raise limits.voxels with --set");
  }
  for (std::size_t i = 0; i < maps.size(); ++i) {
    if (!maps[i]) continue;
    const MapAgreement agreement = compare_volumes(*maps[i], *reference);
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
  const std::vector<bool> front = measured_front(std::move(points));
  for (std::size_t i = 0; i < front.size(); ++i) sweep.cells[i].on_front = front[i];
}

}  // namespace

void judge_sweep(const std::vector<std::optional<MapVolume>>& maps, Sweep& sweep) {
  judge_maps(maps, sweep);
  sweep.error = choose_error(sweep);
  mark_front(sweep);
  if (sweep.error.empty())
    sweep.warnings.push_back("no truth in the log and no map: there is no error to set against run time");
}

}  // namespace sortie::toolchain
