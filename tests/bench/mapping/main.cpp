// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-mapping: the local map beside PCL's batch functions on a recorded drive, thread CPU time, one
// JSON object. The map takes scan after scan; PCL starts anew from the map's voxels each time that it is
// asked. --count yes adds the instructions of each step.
#include <algorithm>
#include <iostream>
#include <stdexcept>

#include "tests/bench/mapping/insertion.hpp"
#include "tests/bench/mapping/map_bytes.hpp"
#include "tests/bench/mapping/normal_error.hpp"
#include "tests/bench/mapping/pcl_batch.hpp"
#include "tests/bench/mapping/planes.hpp"
#include "tests/bench/mapping/sweep.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/counted_child.hpp"
#include "tests/bench/report/figures.hpp"
#include "tests/mapping/owned_map.hpp"
#include "tests/mapping/recorded_scans.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::bench {
namespace {

struct MappingArguments {
  std::string file{std::string(SORTIE_DATA_DIR) + "/lidar_os64/os64_thin4_000_109.rls"};
  std::string dense{std::string(SORTIE_DATA_DIR) + "/lidar_os64/os64_dense_060_071.rls"};
  std::string only;         ///< one part: peers, insertion, planes, normals or sweep
  std::string stream;       ///< of the sweep: walk, dense or hall; empty: all
  std::uint32_t stride{2};  ///< every n-th point
  std::size_t warm_up{40};  ///< scans before the first figure
  std::size_t every{10};    ///< scans between two looks at PCL
  bool count{};             ///< also the instructions of each step; takes minutes
  std::string counted;      ///< in the child that is counted: the policy
};

struct StageTimes {
  Rounds insert_ms;
  Rounds normals_ms;
  Rounds segment_ms;
  Rounds whole_ms;
};

void add_figure(Report& report, const std::string& group, const std::string& what, const Rounds& ours,
                const Rounds& theirs, double goal) {
  Figure figure;
  figure.group = group;
  figure.what = what;
  figure.unit = "ms";
  figure.n = ours.size();
  figure.ours = spread(ours);
  if (!theirs.empty()) {
    figure.peer = "PCL, batch";
    figure.theirs = spread(theirs);
    const double times = theirs.median() / ours.median();
    figure.ratio = spread(times);
    if (goal > 0)
      set_goal(figure, "at least " + std::to_string(static_cast<int>(goal)) + " times faster", times >= goal);
  }
  report.add(figure);
}

/// Every `stride`-th point of a scan.
std::vector<rt::ScanPoint> thinned(const tests::RecordedScan& scan, std::uint32_t stride) {
  std::vector<rt::ScanPoint> points;
  for (std::size_t i = 0; i < scan.points.size(); i += stride) points.push_back(scan.points[i]);
  return points;
}

const tests::MapSizes kSizes{16384, 262136, 32768, 100000, 8192, 16384};

mapping::RollingGridConfig grid_settings() {
  mapping::RollingGridConfig grid;
  grid.radius_m = 15;
  return grid;
}
mapping::SegmenterConfig segmenter_settings() {
  mapping::SegmenterConfig segmenter;
  segmenter.min_voxels = 1;
  return segmenter;
}

/// The child under callgrind: a mark before and after each step.
template <class Policy>
void count_drive(const std::vector<tests::RecordedScan>& scans, std::uint32_t stride) {
  tests::OwnedMap<Policy> map(grid_settings(), segmenter_settings(), kSizes);
  toolchain::start_counting();
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const std::vector<rt::ScanPoint> points = thinned(scans[s], stride);
    rt::PointScan scan = scans[s].view();
    scan.points = points.data();
    scan.header.points = static_cast<std::uint32_t>(points.size());
    const mapping::SensorPose pose = scans[s].pose();
    toolchain::mark_count();
    (void)map.map.update(scan, {pose.p_world_sensor_m, pose.q_world_sensor}, s);
    toolchain::mark_count();
  }
}

/// Worst step over the median one, after the first ten.
void add_counts(const MappingArguments& arguments, const std::string& policy, Report& report) {
  const Marks marks = count_instructions({toolchain::own_program_path(), "--counted", policy, "--file",
                                          arguments.file, "--stride", std::to_string(arguments.stride)});
  if (!marks.why_none.empty()) return report.skip("instructions", marks.why_none);
  Rounds steps;
  for (std::size_t i = 20; i + 1 < marks.instructions.size(); i += 2)
    steps.add(1e-6 * static_cast<double>(marks.instructions[i + 1] - marks.instructions[i]));
  if (steps.empty()) return report.skip("instructions", "the counted program made no marks");
  Figure figure;
  figure.group = policy;
  figure.what = "instructions of a step, after the first ten";
  figure.unit = "M";
  figure.n = steps.size();
  figure.ours = spread(steps);
  const double times = steps.high() / steps.median();
  figure.ratio = spread(times);
  set_goal(figure, "worst at most 2.5 times the median", times <= 2.5);
  report.add(figure);
}

/// One drive with one policy: times of the stages, PCL's on the same voxels, and whether partitions agree.
template <class Policy>
void drive(const std::vector<tests::RecordedScan>& scans, const MappingArguments& arguments,
           const char* group, double goal, Report& report) {
  using Map = tests::OwnedMap<Policy>;
  Map map(grid_settings(), segmenter_settings(), kSizes);
  StageTimes ours;
  PclTimes theirs;
  std::uint64_t differing = 0;
  std::uint64_t compared = 0;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const std::vector<rt::ScanPoint> points = thinned(scans[s], arguments.stride);
    rt::PointScan scan = scans[s].view();
    scan.points = points.data();
    scan.header.points = static_cast<std::uint32_t>(points.size());
    const mapping::SensorPose pose = scans[s].pose();
    const double begin = mapping_cpu_ms();
    (void)map.map.insert(scan, {pose.p_world_sensor_m, pose.q_world_sensor}, s);
    const double inserted = mapping_cpu_ms();
    (void)map.map.update_normals();
    const double solved = mapping_cpu_ms();
    (void)map.map.segment(s);
    const double end = mapping_cpu_ms();
    if (s < arguments.warm_up) continue;
    ours.insert_ms.add(inserted - begin);
    ours.normals_ms.add(solved - inserted);
    ours.segment_ms.add(end - solved);
    ours.whole_ms.add(end - begin);
    if (s % arguments.every != 0 || !has_pcl()) continue;
    PclInput input;
    for (std::uint32_t i = 0; i < map.grid().block_numbers(); ++i) {
      const auto index = static_cast<mapping::BlockIndex>(i);
      const mapping::Block& block = map.grid().block(index);
      if (!block.in_use()) continue;
      for (std::uint64_t rest = block.active; rest != 0; rest = mapping::without_lowest(rest)) {
        const unsigned cell = mapping::lowest(rest);
        const rt::Vector3 p = map.grid().centroid_m(block, cell) - pose.p_world_sensor_m;
        input.voxels.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
        input.segments.push_back(map.segmenter().segment_of(map.grid(), index, cell));
        if (!Map::kNormals) continue;
        const auto& n = map.grid().normal(block, cell).normal;
        input.normals.push_back({static_cast<float>(n[0]) / 32767.0f, static_cast<float>(n[1]) / 32767.0f,
                                 static_cast<float>(n[2]) / 32767.0f});
      }
    }
    for (const rt::ScanPoint& p : points) input.scan.push_back({p.x_m, p.y_m, p.z_m});
    const std::uint64_t wrong = run_pcl(input, Map::kNormals, theirs);
    if (!Map::kNormals) differing += wrong;
    compared += input.voxels.size();
  }
  Rounds segmentation;
  for (std::size_t i = 0; i < theirs.tree_ms.size(); ++i)
    segmentation.add(theirs.tree_ms.values()[i] + theirs.segments_ms.values()[i]);
  add_figure(report, group, "insertion and eviction a step", ours.insert_ms, theirs.filter_ms, 0);
  if (Map::kNormals) add_figure(report, group, "normals a step", ours.normals_ms, theirs.normals_ms, 100);
  add_figure(report, group, "segmentation a step", ours.segment_ms, segmentation, Map::kNormals ? 0 : 150);
  add_figure(report, group, "whole step", ours.whole_ms, theirs.whole_ms, goal);
  const auto& output = map.grid().output();
  Figure memory;
  memory.group = group;
  memory.what = "memory a voxel held";
  memory.unit = "B";
  memory.n = output.most_voxels;
  const double bytes = most_map_bytes(map) / output.most_voxels;
  memory.ours = spread(bytes);
  set_goal(memory, Map::kNormals ? "at most 80" : "at most 32", bytes <= (Map::kNormals ? 80 : 32));
  report.add(memory);
  if (!theirs.angles_deg.empty()) {
    std::sort(theirs.angles_deg.begin(), theirs.angles_deg.end());
    const auto quantile = [&theirs](double share) {
      const auto at = static_cast<std::size_t>(share * static_cast<double>(theirs.angles_deg.size() - 1));
      return std::to_string(theirs.angles_deg[at]);
    };
    report.note(group, "normals of flat voxels are off PCL's on the current means by " + quantile(0.5) +
                           " deg (median), " + quantile(0.95) + " deg (95 %)");
  }
  if (!Map::kNormals && has_pcl()) {
    Figure figure;
    figure.group = group;
    figure.what = "voxels in another cluster than PCL's EuclideanClusterExtraction puts them in";
    figure.unit = "voxels";
    figure.n = compared;
    figure.ours = spread(static_cast<double>(differing));
    set_goal(figure, "0", differing == 0);
    report.add(figure);
  }
  report.note(group, "the window's table takes " + std::to_string(map.owned.window.size() * 2 / 1024) +
                         " kB besides");
}

int run(const MappingArguments& arguments) {
  const std::vector<tests::RecordedScan> scans = tests::read_rls(arguments.file);
  if (arguments.counted == "smoothness")
    return count_drive<mapping::SmoothnessPolicy>(scans, arguments.stride), 0;
  if (!arguments.counted.empty()) return count_drive<mapping::EuclideanPolicy>(scans, arguments.stride), 0;
  Report report;
  Json& root = report.root();
  root["load_before"] = load_average();
  for (const char* list : {"figures", "tables", "skipped", "notes", "sweep", "pictures"})
    root[list] = Json::array();
  root["settings"] = {{"stride", arguments.stride}, {"every", arguments.every}, {"only", arguments.only}};
  if (scans.empty()) report.skip("recorded drive", "no scans in " + arguments.file);
  if (!has_pcl()) report.skip("PCL", "not there when this was built; apt-get install libpcl-dev");
  const auto wanted = [&arguments](const char* part) {
    return arguments.only.empty() || arguments.only == part;
  };
  if (wanted("peers") && !scans.empty()) {
    drive<mapping::EuclideanPolicy>(scans, arguments, "Euclidean", 100, report);
    drive<mapping::SmoothnessPolicy>(scans, arguments, "smoothness", 120, report);
    if (arguments.count) {
      add_counts(arguments, "Euclidean", report);
      add_counts(arguments, "smoothness", report);
    }
  }
  if (wanted("insertion")) {
    if (!scans.empty()) insertion_beside_sorted(scans, arguments.stride, report);
    insertion_by_size(report);
  }
  if (wanted("planes")) plane_times(report);
  const MappingStream walk = recorded_stream("walk", arguments.file, arguments.stride);
  if (wanted("normals") && !walk.scans.empty()) normal_errors(walk, report);
  if (wanted("sweep")) {
    for (const MappingStream& stream :
         {walk, recorded_stream("dense", arguments.dense, 4 * arguments.stride), simulated_hall()}) {
      if (!arguments.stream.empty() && arguments.stream != stream.name) continue;
      if (stream.scans.empty())
        report.skip(stream.name, "no scans");
      else
        sweep_stream(stream, report);
    }
  }
  root["load_after"] = load_average();
  std::cout << root.dump() << std::endl;
  return 0;
}

MappingArguments parse(int argc, char** argv) {
  MappingArguments all;
  for (int i = 1; i < argc; i += 2) {
    const std::string option = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : nullptr;
    if (option == "--file" && value != nullptr)
      all.file = value;
    else if (option == "--dense" && value != nullptr)
      all.dense = value;
    else if (option == "--stream" && value != nullptr)
      all.stream = value;
    else if (option == "--only" && value != nullptr)
      all.only = value;
    else if (option == "--stride")
      all.stride = static_cast<std::uint32_t>(number("--stride", value, 1, 1e6));
    else if (option == "--every")
      all.every = static_cast<std::size_t>(number("--every", value, 1, 1e6));
    else if (option == "--count" && value != nullptr)
      all.count = std::string(value) == "yes";
    else if (option == "--counted" && value != nullptr)
      all.counted = value;
    else
      throw std::invalid_argument("unknown option " + option);
  }
  return all;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main(
      "sortie-bench-mapping", [argc, argv] { return sortie::bench::run(sortie::bench::parse(argc, argv)); });
}
