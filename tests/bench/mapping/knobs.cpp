// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/knobs.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <unordered_map>

#include "tests/bench/mapping/batch.hpp"
#include "tests/bench/mapping/insertion.hpp"
#include "tests/bench/mapping/rand_index.hpp"
#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {
namespace {

constexpr double kRadius_m = 15;
constexpr double kInner_m = 13;  // where probes are asked for: away from what rolls out of the map
constexpr std::size_t kProbeEvery = 3;
constexpr double kMostAngle_rad = 4 * 3.14159265358979 / 180;
constexpr double kMostCurvature = 0.05;
constexpr std::uint32_t kAlone = 0x80000000u;  // added to an index: a label that nobody shares
constexpr double kLeastMargin = 0.05;

std::vector<MapCell> cells_of(bool smooth) {
  // The finest first: the others are held against it.
  std::vector<MapCell> cells{{"voxel", "0.075 m", 0.075}, {"profile", "", 0.1}};
  for (const double voxel_m : {0.15, 0.2, 0.3}) {
    MapCell cell{"voxel", std::to_string(voxel_m).substr(0, voxel_m == 0.15 ? 4 : 3) + " m", voxel_m};
    cells.push_back(cell);
  }
  for (const std::uint32_t points : {2u, 3u, 5u})
    cells.push_back({"min points", std::to_string(points), 0.1, points});
  for (const std::uint32_t units : {131072u, 65536u, 32768u, 16384u, 4096u})
    cells.push_back({"units", std::to_string(units), 0.1, 1, units});
  if (smooth) {
    for (const std::uint32_t solves : {8192u, 4096u, 1024u})
      cells.push_back({"solves", std::to_string(solves), 0.1, 1, 0, solves});
  }
  return cells;
}

/// A point of the newest scan at a look, in the world.
struct Probe {
  rt::Vector3 p_m;
  std::uint32_t face{};
};

std::vector<Probe> probes_of(const MapDrive& drive, std::size_t s) {
  const tests::RecordedScan& scan = drive.scans[s];
  const mapping::SensorPose pose = scan.pose();
  std::vector<Probe> probes;
  for (std::size_t i = 0; i < scan.points.size(); i += kProbeEvery) {
    const rt::ScanPoint& q = scan.points[i];
    const rt::Vector3 local{q.x_m, q.y_m, q.z_m};
    const double range = rt::norm(local);
    const rt::Vector3 turned = rt::rotate(pose.q_world_sensor, local);
    if (!(range > 0.6) || std::hypot(turned.x, turned.y) > kInner_m ||
        std::fabs(turned.z) > 0.8 * drive.half_height_m)
      continue;
    probes.push_back({turned + pose.p_world_sensor_m, drive.faces.empty() ? 0 : drive.faces[s][i]});
  }
  return probes;
}

std::uint64_t cell_name(const rt::Vector3& p, double voxel_m) {
  const auto part = [voxel_m](double v) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v / voxel_m)) + (1 << 20)) &
           0x1fffffu;
  };
  return part(p.x) << 42 | part(p.y) << 21 | part(p.z);
}

/// What one cell gave, over all looks.
struct CellResult {
  Rounds step_ms;
  Rounds units;
  Rounds agreement;  ///< with the batch on the same voxels, a value a look
  Rounds finest;     ///< with the batch on the finest voxels, by points
  Rounds truth;      ///< with the faces of the simulated world, by points
  Rounds held;       ///< share of the newest scan's points that lie in an active voxel
  Rounds backlog;
  std::vector<double> normal_deg;
  double bytes{};
  std::uint64_t voxels{};
  std::uint64_t pool_full{};
};

double quantile_of(std::vector<double>& values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

double mean_of(const Rounds& rounds) {
  if (rounds.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (const double value : rounds.values()) sum += value;
  return sum / static_cast<double>(rounds.size());
}

/// Labels of the finest map at each look, by probe; kAlone + index where it holds no voxel there.
using FinestLabels = std::vector<std::vector<std::uint32_t>>;

template <class Map>
void look(const MapDrive& drive, std::size_t s, const Map& map, const MapCell& cell, double radius_m,
          double normal_radius_m, std::size_t number, FinestLabels& finest, CellResult& result) {
  std::vector<BatchVoxel> voxels = active_voxels(map.grid());
  std::vector<std::uint32_t> own(voxels.size());
  std::unordered_map<std::uint64_t, std::uint32_t> at;
  for (std::uint32_t i = 0; i < voxels.size(); ++i) {
    const auto id = map.segmenter().segment_of(map.grid(), voxels[i].block, voxels[i].cell);
    own[i] = id == mapping::kNoSegment ? kAlone + i : static_cast<std::uint32_t>(id);
    at[cell_name(map.grid().to_world(voxels[i].p_m), cell.voxel_m)] = i;
  }
  std::vector<std::uint32_t> batch;
  if constexpr (Map::kNormals) {
    const std::vector<BatchNormal> normals = batch_normals(voxels, normal_radius_m);
    batch = smooth_batch(voxels, normals, radius_m, kMostAngle_rad, kMostCurvature);
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const rt::Vector3& n = voxels[i].normal;
      const rt::Vector3& m = normals[i].normal;
      if (normals[i].margin < kLeastMargin || (n.x == 0 && n.y == 0 && n.z == 0)) continue;
      const double c = std::fabs(n.x * m.x + n.y * m.y + n.z * m.z) / rt::norm(n);
      result.normal_deg.push_back(std::acos(std::min(1.0, c)) * 180 / 3.14159265358979);
    }
  } else {
    batch = euclidean_batch(voxels, radius_m);
  }
  result.agreement.add(adjusted_rand_index(own, batch));

  const std::vector<Probe> probes = probes_of(drive, s);
  const bool first = finest.size() <= number;
  if (first) finest.emplace_back(probes.size());
  std::vector<std::uint32_t> mine;
  std::vector<std::uint32_t> theirs;
  std::vector<std::uint32_t> faces;
  for (std::uint32_t i = 0; i < probes.size(); ++i) {
    const auto found = at.find(cell_name(probes[i].p_m, cell.voxel_m));
    if (first) finest[number][i] = found == at.end() ? kAlone + i : batch[found->second];
    if (found == at.end()) continue;
    mine.push_back(own[found->second]);
    theirs.push_back(finest[number][i]);
    faces.push_back(probes[i].face);
  }
  result.held.add(probes.empty() ? 1 : static_cast<double>(mine.size()) / static_cast<double>(probes.size()));
  result.finest.add(adjusted_rand_index(mine, theirs));
  if (!drive.faces.empty()) result.truth.add(adjusted_rand_index(mine, faces));
}

template <class Policy>
CellResult run_cell(const MapDrive& drive, const KnobOptions& options, const MapCell& cell,
                    FinestLabels& finest) {
  mapping::RollingGridConfig grid;
  grid.radius_m = kRadius_m;
  grid.half_height_m = drive.half_height_m;
  grid.voxel_size_m = cell.voxel_m;
  grid.min_points = cell.min_points;
  mapping::SegmenterConfig segmenter;
  segmenter.min_voxels = 1;
  segmenter.radius_m = 2 * cell.voxel_m;
  segmenter.units = cell.units;
  mapping::NormalsConfig normals;
  normals.radius_m = 3 * cell.voxel_m;
  normals.restate_m = 0.3 * cell.voxel_m;
  normals.solves = cell.solves;
  const tests::MapSizes sizes{32768, 262136, 65534, 100000, 16384, 32768};
  const auto map = [&] {
    if constexpr (std::is_same_v<Policy, mapping::EuclideanPolicy>)
      return std::make_unique<tests::OwnedMap<Policy>>(grid, segmenter, sizes);
    else
      return std::make_unique<tests::OwnedMap<Policy>>(grid, segmenter, sizes,
                                                       Policy{kMostAngle_rad, kMostCurvature}, normals);
  }();
  CellResult result;
  std::size_t looks = 0;
  for (std::size_t s = 0; s < drive.scans.size(); ++s) {
    const mapping::SensorPose pose = drive.scans[s].pose();
    const double begin = mapping_cpu_ms();
    const mapping::LocalMapStep step =
        map->map.update(drive.scans[s].view(), {pose.p_world_sensor_m, pose.q_world_sensor}, s);
    const double end = mapping_cpu_ms();
    if (s < options.warm_up) continue;
    result.step_ms.add(end - begin);
    result.units.add(step.segments.units);
    result.backlog.add(step.segments.backlog + step.normals.backlog);
    if ((s - options.warm_up) % options.every == 0)
      look(drive, s, *map, cell, segmenter.radius_m, normals.radius_m, looks++, finest, result);
  }
  const auto& output = map->grid().output();
  const double nodes = map->segmenter().graph().most_in_use() *
                       static_cast<double>(sizeof(mapping::FragmentNode) + sizeof(mapping::NodeWork) +
                                           sizeof(mapping::SegmentComponent) + 2);
  double blocks = output.most_blocks * static_cast<double>(sizeof(mapping::BlockWork) + 4);
  if (tests::OwnedMap<Policy>::kNormals)
    blocks += output.most_blocks * static_cast<double>(sizeof(mapping::NormalWork) + 4);
  result.bytes = static_cast<double>(map->grid().most_bytes()) + nodes + blocks;
  result.voxels = output.most_voxels;
  result.pool_full = output.points.pool_full;
  return result;
}

Json rounded(double value, int digits) {
  if (!std::isfinite(value)) return "";
  const double scale = std::pow(10.0, digits);
  return std::round(value * scale) / scale;
}

template <class Policy>
void sweep_policy(const MapDrive& drive, const KnobOptions& options, const std::string& policy,
                  Report& report) {
  constexpr bool kSmooth = tests::OwnedMap<Policy>::kNormals;
  const std::string group = drive.name + ", " + policy;
  FinestLabels finest;
  for (const MapCell& cell : cells_of(kSmooth)) {
    std::cerr << "mapping: " << group << ", " << cell.knob << " " << cell.value << "\n";
    CellResult r = run_cell<Policy>(drive, options, cell, finest);
    Json row{{"group", group}, {"knob", cell.knob}, {"value", cell.value}};
    row["n"] = r.step_ms.size();
    row["p50_ms"] = r.step_ms.median();
    row["p99_ms"] = r.step_ms.quantile(0.99);
    row["max_ms"] = r.step_ms.high();
    row["kB"] = std::round(r.bytes / 1024);
    row["voxels"] = r.voxels;
    row["units"] = r.units.median();
    row["batch"] = rounded(mean_of(r.agreement), 5);
    row["finest"] = rounded(mean_of(r.finest), 4);
    row["truth"] = rounded(mean_of(r.truth), 4);
    row["held"] = rounded(mean_of(r.held), 4);
    row["backlog"] = rounded(mean_of(r.backlog), 1);
    row["normal_p50_deg"] = rounded(quantile_of(r.normal_deg, 0.5), 2);
    row["normal_p95_deg"] = rounded(quantile_of(r.normal_deg, 0.95), 2);
    row["pool_full"] = r.pool_full;
    report.root()["map_rows"].push_back(row);
  }
}

}  // namespace

void sweep_knobs(const MapDrive& drive, const KnobOptions& options, Report& report) {
  sweep_policy<mapping::EuclideanPolicy>(drive, options, "Euclidean", report);
  sweep_policy<mapping::SmoothnessPolicy>(drive, options, "smoothness", report);
}

}  // namespace sortie::bench
