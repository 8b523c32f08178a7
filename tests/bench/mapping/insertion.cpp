// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/insertion.hpp"

#include <time.h>

#include "tests/bench/mapping/sorted_grid.hpp"
#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {
namespace {

rt::PointScan scan_of(const std::vector<rt::ScanPoint>& points) {
  rt::PointScan scan;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return scan;
}

/// A voxel each, in layers of 200 x 200 cells that lie 0.4 m apart; `share` of the way into the cells.
std::vector<rt::ScanPoint> layers(std::uint32_t voxels, float share) {
  std::vector<rt::ScanPoint> points;
  for (std::uint32_t i = 0; i < voxels; ++i) {
    const auto at = [share](std::uint32_t cell) {
      return 0.1f * (static_cast<float>(cell) - 100.0f + share);
    };
    points.push_back(
        {at(i % 200), at(i / 200 % 200), 0.4f * static_cast<float>(i / 40000) + 0.1f * share, 0, 0});
  }
  return points;
}
}  // namespace

double mapping_cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

void insertion_beside_sorted(const std::vector<tests::RecordedScan>& scans, std::uint32_t stride,
                             Report& report) {
  mapping::RollingGridConfig config;
  config.radius_m = 15;
  tests::OwnedRollingGrid ours(config, {16384, 262136, 0, 100000, 0, 0});
  SortedGrid theirs(0.1f);
  Rounds own_ns;
  Rounds their_ns;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const mapping::SensorPose pose = scans[s].pose();
    std::vector<rt::ScanPoint> local;
    std::vector<rt::ScanPoint> world;
    for (std::size_t i = 0; i < scans[s].points.size(); i += stride) {
      const rt::ScanPoint& p = scans[s].points[i];
      const rt::Vector3 d =
          rt::rotate(pose.q_world_sensor,
                     {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)});
      // Those that the grid takes.
      if (d.x * d.x + d.y * d.y > 15.0 * 15.0 || std::fabs(d.z) > config.half_height_m || norm(d) < 0.5)
        continue;
      const rt::Vector3 w = d + pose.p_world_sensor_m;
      local.push_back(p);
      world.push_back({static_cast<float>(w.x), static_cast<float>(w.y), static_cast<float>(w.z), 0, 0});
    }
    if (local.empty()) continue;
    const double t0 = mapping_cpu_ms();
    (void)ours.grid.insert(scan_of(local), {pose.p_world_sensor_m, pose.q_world_sensor}, s, {});
    const double t1 = mapping_cpu_ms();
    theirs.insert(world);
    const double t2 = mapping_cpu_ms();
    theirs.keep_within(pose.p_world_sensor_m.x, pose.p_world_sensor_m.y, 15.4);  // not timed
    if (s < 40) continue;
    own_ns.add(1e6 * (t1 - t0) / static_cast<double>(local.size()));
    their_ns.add(1e6 * (t2 - t1) / static_cast<double>(local.size()));
  }
  if (own_ns.empty()) return;
  Figure figure;
  figure.group = "insertion";
  figure.what = "insertion and our eviction, a point";
  figure.unit = "ns";
  figure.n = own_ns.size();
  figure.ours = spread(own_ns);
  figure.peer = "sorted vector, insertion alone";
  figure.theirs = spread(their_ns);
  const double times = their_ns.median() / own_ns.median();
  figure.ratio = spread(times);
  set_goal(figure, "at least 2.3 times faster", times >= 2.3);
  report.add(figure);
}

void insertion_by_size(Report& report) {
  mapping::RollingGridConfig config;
  config.min_range_m = 0;
  const std::uint32_t sizes[] = {10000, 25000, 50000, 100000, 150000};
  Rounds ns[std::size(sizes)];
  for (int round = 0; round < 15; ++round) {
    for (std::size_t k = 0; k < std::size(sizes); ++k) {
      tests::OwnedRollingGrid map(config, {16384, 262136, 0, 200000, 0, 0});
      (void)map.grid.insert(scan_of(layers(sizes[k], 0.3f)), {}, 1, {});
      Rounds steps;
      for (std::uint32_t step = 0; step < 9; ++step) {
        const std::vector<rt::ScanPoint> scan = layers(8000, 0.4f + 0.05f * static_cast<float>(step));
        const double begin = mapping_cpu_ms();
        (void)map.grid.insert(scan_of(scan), {}, 2 + step, {});
        steps.add(1e6 * (mapping_cpu_ms() - begin) / 8000.0);
      }
      ns[k].add(steps.median());
    }
  }
  Json rows = Json::array();
  double least = 1e9;
  double most = 0;
  for (std::size_t k = 0; k < std::size(sizes); ++k) {
    rows.push_back({sizes[k], ns[k].median(), ns[k].low(), ns[k].high()});
    least = std::min(least, ns[k].median());
    most = std::max(most, ns[k].median());
  }
  report.add_table("insertion", {"voxels in the map", "ns a point", "lowest", "highest"}, rows);
  Figure figure;
  figure.group = "insertion";
  figure.what = "slowest over fastest size of map, 10,000 to 150,000 voxels";
  figure.unit = "times";
  figure.n = 15;
  figure.ours = spread(most / least);
  set_goal(figure, "at most 1.15", most / least <= 1.15);
  report.add(figure);
}

}  // namespace sortie::bench
