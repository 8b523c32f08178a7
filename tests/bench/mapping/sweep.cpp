// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/sweep.hpp"

#include <algorithm>
#include <cmath>

#include "tests/bench/mapping/heap_count.hpp"
#include "tests/bench/mapping/insertion.hpp"
#include "tests/bench/mapping/map_bytes.hpp"
#include "tests/bench/mapping/reference.hpp"

namespace sortie::bench {
namespace {

/// One choice of settings; the defaults are those of the map.
struct SweepCell {
  const char* knob;
  double voxel_m{0.1};
  std::uint32_t min_points{1};
  std::uint32_t units{0};
  std::uint32_t solves{0};
  double restate_m{0.03};
};

const SweepCell kEuclideanCells[] = {{"defaults"},
                                     {"voxel", 0.05},
                                     {"voxel", 0.075},
                                     {"voxel", 0.15},
                                     {"voxel", 0.2},
                                     {"points", 0.1, 2},
                                     {"points", 0.1, 4},
                                     {"units", 0.1, 1, 2000},
                                     {"units", 0.1, 1, 10000},
                                     {"units", 0.1, 1, 50000}};
const SweepCell kSmoothCells[] = {{"defaults"},
                                  {"voxel", 0.075},
                                  {"voxel", 0.15},
                                  {"voxel", 0.2},
                                  {"points", 0.1, 2},
                                  {"points", 0.1, 4},
                                  {"units", 0.1, 1, 10000},
                                  {"units", 0.1, 1, 50000},
                                  {"solves", 0.1, 1, 0, 2000},
                                  {"solves", 0.1, 1, 0, 6000},
                                  {"restate", 0.1, 1, 0, 0, 0.01},
                                  {"restate", 0.1, 1, 0, 0, 0.1}};

double angle_deg(const std::int16_t (&a)[3], const TwinPoint& b) {
  double dot = 0;
  double square = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    dot += a[i] * b[i];
    square += 1.0 * a[i] * a[i];
  }
  return 57.29577951308232 * std::acos(std::min(1.0, std::fabs(dot) / std::sqrt(square)));
}

/// How far the map agrees with the fine reference.
template <class Map>
void add_errors(const Map& map, const Reference& reference, double voxel_m, Json& row) {
  std::vector<std::uint32_t> labels;
  Rounds angles;
  std::uint64_t expected = 0;
  std::uint64_t missed = 0;
  const std::vector<std::uint32_t>& truth = Map::kNormals ? reference.surfaces : reference.clusters;
  for (std::size_t i = 0; i < reference.samples.size(); ++i) {
    labels.push_back(kNoTwinLabel);
    std::int32_t cell[3];
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<std::int32_t>(std::floor(reference.samples[i][axis] / voxel_m));
    const mapping::BlockIndex index = map.grid().find({cell[0] >> 2, cell[1] >> 2, cell[2] >> 2});
    const auto number = static_cast<unsigned>((cell[0] & 3) + 4 * (cell[1] & 3) + 16 * (cell[2] & 3));
    const bool there =
        index != mapping::kNoBlock && (map.grid().block(index).active & mapping::cell_bit(number)) != 0;
    const std::uint32_t id = there ? map.segmenter().segment_of(map.grid(), index, number) : 0;
    if (id != 0) labels.back() = id;
    expected += truth[i] != kNoTwinLabel ? 1 : 0;
    missed += truth[i] != kNoTwinLabel && id == 0 ? 1 : 0;
    if (!Map::kNormals || !there) continue;
    const TwinNormal& right = reference.normals[i];
    const auto& record = map.grid().normal(map.grid().block(index), number);
    if (record.has_normal() && right.count >= 3 && right.gap > 0.05 && right.curvature < 0.05)
      angles.add(angle_deg(record.normal, right.normal));
  }
  row["agreement"] = adjusted_rand(labels, truth);
  row["missed"] = static_cast<double>(missed) / static_cast<double>(std::max<std::uint64_t>(1, expected));
  row["normal_deg"] = angles.empty() ? Json() : Json(angles.median());
  row["normal_p95_deg"] = angles.empty() ? Json() : Json(angles.quantile(0.95));
}

/// All active voxels with their segments.
struct Shown {
  std::vector<TwinPoint> points;
  std::vector<std::uint32_t> labels;
};

template <class Map>
Shown shown_by(const Map& map) {
  Shown all;
  for (std::uint32_t i = 0; i < map.grid().block_numbers(); ++i) {
    const auto index = static_cast<mapping::BlockIndex>(i);
    const mapping::Block& block = map.grid().block(index);
    if (!block.in_use()) continue;
    for (std::uint64_t rest = block.active; rest != 0; rest = mapping::without_lowest(rest)) {
      const unsigned cell = mapping::lowest(rest);
      const rt::Vector3 p = map.grid().centroid_m(block, cell);
      all.points.push_back({p.x, p.y, p.z});
      const std::uint32_t id = map.segmenter().segment_of(map.grid(), index, cell);
      all.labels.push_back(id == 0 ? kNoTwinLabel : id);
    }
  }
  return all;
}

/// How far the map agrees with the batch over its own voxels' means.
template <class Map>
double own_agreement(const Shown& shown, double grow_m, double normals_m) {
  if (!Map::kNormals) return adjusted_rand(shown.labels, twin_clusters(shown.points, grow_m));
  const std::vector<TwinNormal> normals = twin_normals(shown.points, normals_m);
  return adjusted_rand(shown.labels, twin_surfaces(shown.points, normals, grow_m, 0.07, 0.05));
}

/// The voxels between half a metre below and half a metre above the sensor, seen from above.
Json picture_of(const MappingStream& stream, const Shown& shown, const char* policy) {
  const double z = stream.scans.back().pose.p.z;
  Json x = Json::array();
  Json y = Json::array();
  Json label = Json::array();
  for (std::size_t i = 0; i < shown.points.size(); ++i) {
    if (shown.labels[i] == kNoTwinLabel || std::fabs(shown.points[i][2] - z) > 0.25) continue;
    x.push_back(std::round(100 * shown.points[i][0]) / 100);
    y.push_back(std::round(100 * shown.points[i][1]) / 100);
    label.push_back(shown.labels[i]);
  }
  return {{"stream", stream.name}, {"policy", policy}, {"x", x}, {"y", y}, {"segment", label}};
}

template <class Policy>
void sweep_policy(const MappingStream& stream, const Reference& reference, const SweepRadii& radii,
                  const char* policy, std::span<const SweepCell> cells, Report& report) {
  std::uint64_t beyond = 0;
  std::uint64_t heap = 0;
  std::uint64_t lost = 0;
  std::uint64_t points = 0;
  for (const SweepCell& cell : cells) {
    mapping::RollingGridConfig grid;
    grid.voxel_size_m = cell.voxel_m;
    grid.radius_m = radii.map_m;
    grid.min_points = cell.min_points;
    mapping::SegmenterConfig segmenter;
    // Beyond 2 voxels' size neighbours on a plane would not reach one another any more.
    segmenter.radius_m = std::max(radii.grow_m, 1.5 * cell.voxel_m);
    segmenter.min_voxels = 1;
    segmenter.units = cell.units;
    mapping::NormalsConfig normals;
    normals.radius_m = std::max(radii.normals_m, 2.0 * cell.voxel_m);
    normals.restate_m = cell.restate_m;
    normals.solves = cell.solves;
    using Map = tests::OwnedMap<Policy>;
    Map map(grid, segmenter, {32768, 262136, 65534, 100000, 16384, 16384}, Policy{}, normals);
    Rounds step_ms;
    Rounds waiting;
    const std::size_t warm_up = std::min<std::size_t>(40, stream.scans.size() / 3);
    for (std::size_t s = 0; s < stream.scans.size(); ++s) {
      const std::uint64_t heap_before = heap_calls();
      const double begin = mapping_cpu_ms();
      const mapping::LocalMapStep step = map.map.update(stream.scans[s].view(), stream.scans[s].pose, s);
      const double ms = mapping_cpu_ms() - begin;
      heap += heap_calls() - heap_before;
      if (cell.units > 0 && step.segments.units > cell.units)
        beyond = std::max<std::uint64_t>(beyond, step.segments.units - cell.units);
      if (s < warm_up) continue;
      step_ms.add(ms);
      waiting.add(step.segments.backlog + step.normals.backlog);
    }
    const mapping::RollingGridCounts& c = map.grid().output().points;
    points += c.in;
    lost += c.in - (c.used + c.not_finite + c.too_near + c.too_far + c.outside + c.out_of_grid + c.pool_full +
                    c.scan_full + c.bad_pose);
    const Shown shown = shown_by(map);
    const auto voxels = static_cast<double>(map.grid().output().most_voxels);
    Json row{{"stream", stream.name},
             {"policy", policy},
             {"knob", cell.knob},
             {"voxel_m", cell.voxel_m},
             {"min_points", cell.min_points},
             {"units", cell.units},
             {"solves", cell.solves},
             {"restate_m", Map::kNormals ? Json(cell.restate_m) : Json()},
             {"n", step_ms.size()},
             {"p50_ms", step_ms.median()},
             {"p99_ms", step_ms.quantile(0.99)},
             {"max_ms", step_ms.high()},
             {"voxels", map.grid().output().most_voxels},
             {"bytes_a_voxel", most_map_bytes(map) / voxels},
             {"mb", 1e-6 * most_map_bytes(map)},
             {"waiting_blocks", waiting.median()},
             {"pool_full", c.pool_full},
             {"own_agreement", own_agreement<Map>(shown, segmenter.radius_m, normals.radius_m)}};
    add_errors(map, reference, cell.voxel_m, row);
    report.root()["sweep"].push_back(row);
    if (&cell == &cells.front()) report.root()["pictures"].push_back(picture_of(stream, shown, policy));
  }
  const auto figure = [&](const char* what, const char* unit, std::uint64_t value, std::uint64_t most) {
    Figure line;
    line.group = "bounds";
    line.what = stream.name + ", " + policy + ": " + what;
    line.unit = unit;
    line.n = points;
    line.ours = spread(static_cast<double>(value));
    set_goal(line, "at most " + std::to_string(most), value <= most);
    report.add(line);
  };
  figure("work beyond the budget in any step", "units", beyond, mapping::Segmenter<Policy>::kBlockUnits);
  figure("heap calls in all steps", "calls", heap, 0);
  figure("points without a fate", "points", lost, 0);
}

}  // namespace

void sweep_stream(const MappingStream& stream, Report& report) {
  const SweepRadii radii;
  const Reference reference = reference_of(stream, radii);
  sweep_policy<mapping::EuclideanPolicy>(stream, reference, radii, "Euclidean", kEuclideanCells, report);
  sweep_policy<mapping::SmoothnessPolicy>(stream, reference, radii, "smoothness", kSmoothCells, report);
}

}  // namespace sortie::bench
