// SPDX-License-Identifier: BSD-3-Clause
// The voxel grid against a hash map, a sorted vector and, where it is installed, PCL, on the same simulated
// scans of a hall; ns per point. The grid also checks and counts each point, which no peer does.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <unordered_map>
#include <vector>

#include "mapping/grid/rolling_grid.hpp"
#include "mapping/grid/sensor_pose.hpp"
#include "tests/bench/ratio_table.hpp"
#ifdef SORTIE_PEER_PCL
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#endif

namespace {

using namespace sortie;

constexpr std::uint32_t kPoints = 8192;
constexpr std::uint32_t kScans = 16;
constexpr double kSize = 0.1;

struct Drive {
  std::vector<std::vector<rt::ScanPoint>> scans;
  std::vector<mapping::SensorPose> poses;
};

// Walls, floor and ceiling of a hall of 20 x 12 x 3 m, seen from a way through its middle.
const Drive& drive() {
  static const Drive made = [] {
    Drive result;
    std::mt19937 random(3);
    const auto draw = [&random](double low, double high) {
      return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
    };
    for (std::uint32_t s = 0; s < kScans; ++s) {
      const rt::Vector3 at{-8.0 + static_cast<double>(s), 0.0, 1.0};
      std::vector<rt::ScanPoint>& scan = result.scans.emplace_back();
      for (std::uint32_t i = 0; i < kPoints; ++i) {
        double p[3] = {draw(-10, 10), draw(-6, 6), draw(0, 3)};
        const auto face = static_cast<std::size_t>(random() % 6);
        const double face_at[6] = {-10, 10, -6, 6, 0, 3};
        p[face / 2] = face_at[face] + draw(-0.01, 0.01);
        scan.push_back({static_cast<float>(p[0] - at.x), static_cast<float>(p[1] - at.y),
                        static_cast<float>(p[2] - at.z), 0, 0});
      }
      result.poses.push_back({at, {}});
    }
    return result;
  }();
  return made;
}

struct Cell {
  double sum[3]{};
  std::uint32_t count{};
};

// 21 bits an axis.
std::uint64_t key_of(const double (&p)[3]) {
  std::uint64_t key = 0;
  for (const double value : p)
    key = (key << 21) |
          static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value / kSize)) + (1 << 20));
  return key;
}

void to_world(const rt::ScanPoint& point, const mapping::SensorPose& pose, double (&p)[3]) {
  const rt::Vector3 world =
      pose.p_world_sensor_m +
      rt::rotate(pose.q_world_sensor, {static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                                       static_cast<double>(point.z_m)});
  p[0] = world.x;
  p[1] = world.y;
  p[2] = world.z;
}

void count_ops(benchmark::State& state) { state.counters["ops"] = 1.0 * kPoints * kScans; }

void voxel_sortie(benchmark::State& state) {
  constexpr std::uint32_t kCapacity = 1u << 17;
  mapping::RollingGridConfig config;
  config.voxel_size_m = kSize;
  config.min_range_m = 0.0001;
  config.radius_m = 30;
  std::vector<mapping::Block> blocks(kCapacity / 4);
  std::vector<mapping::BlockIndex> window(mapping::RollingGrid::window_entries(config));
  std::vector<mapping::Centroid> voxels(kCapacity);
  std::vector<mapping::ScanEntry> entries(kPoints);
  std::vector<mapping::BlockChange> changes(blocks.size());
  for (auto _ : state) {
    state.PauseTiming();
    std::fill(blocks.begin(), blocks.end(), mapping::Block{});
    auto grid = std::make_unique<mapping::RollingGrid>(
        config, mapping::RollingGridMemory{blocks, window, voxels, {}, entries, changes});
    state.ResumeTiming();
    for (std::uint32_t s = 0; s < kScans; ++s) {
      rt::PointScan scan;
      scan.header.stamp_ns = s;
      scan.header.points = kPoints;
      scan.points = drive().scans[s].data();
      benchmark::DoNotOptimize(
          grid->insert(scan, {drive().poses[s].p_world_sensor_m, drive().poses[s].q_world_sensor}, s, {}));
    }
  }
  count_ops(state);
}
BENCHMARK(voxel_sortie)->Name("voxel_insert/sortie");

void voxel_unordered_map(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    std::unordered_map<std::uint64_t, Cell> map;
    map.reserve(1u << 17);
    state.ResumeTiming();
    for (std::uint32_t s = 0; s < kScans; ++s) {
      for (const rt::ScanPoint& point : drive().scans[s]) {
        double p[3];
        to_world(point, drive().poses[s], p);
        Cell& cell = map[key_of(p)];
        for (int i = 0; i < 3; ++i) cell.sum[i] += p[i];
        ++cell.count;
      }
    }
    benchmark::DoNotOptimize(map.size());
    state.PauseTiming();
    map.clear();
    state.ResumeTiming();
  }
  count_ops(state);
}
BENCHMARK(voxel_unordered_map)->Name("voxel_insert/std::unordered_map, reserved");

// Each scan is sorted and merged into the map: no hashing, but the whole map moves with every scan.
void voxel_sorted_vector(benchmark::State& state) {
  using Entry = std::pair<std::uint64_t, Cell>;
  const auto less = [](const Entry& a, const Entry& b) { return a.first < b.first; };
  for (auto _ : state) {
    std::vector<Entry> map;
    std::vector<Entry> merged;
    std::vector<Entry> fresh;
    for (std::uint32_t s = 0; s < kScans; ++s) {
      fresh.clear();
      for (const rt::ScanPoint& point : drive().scans[s]) {
        double p[3];
        to_world(point, drive().poses[s], p);
        fresh.push_back({key_of(p), {{p[0], p[1], p[2]}, 1}});
      }
      std::sort(fresh.begin(), fresh.end(), less);
      merged.resize(map.size() + fresh.size());
      std::merge(map.begin(), map.end(), fresh.begin(), fresh.end(), merged.begin(), less);
      std::size_t kept = 0;
      for (std::size_t i = 1; i < merged.size(); ++i) {
        if (merged[i].first != merged[kept].first) {
          merged[++kept] = merged[i];
          continue;
        }
        for (int k = 0; k < 3; ++k) merged[kept].second.sum[k] += merged[i].second.sum[k];
        merged[kept].second.count += merged[i].second.count;
      }
      merged.resize(kept + 1);
      std::swap(map, merged);
    }
    benchmark::DoNotOptimize(map.size());
  }
  count_ops(state);
}
BENCHMARK(voxel_sorted_vector)->Name("voxel_insert/sorted std::vector, merged");

#ifdef SORTIE_PEER_PCL
void voxel_pcl(benchmark::State& state) {
  auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (std::uint32_t s = 0; s < kScans; ++s) {
    for (const rt::ScanPoint& point : drive().scans[s]) {
      double p[3];
      to_world(point, drive().poses[s], p);
      cloud->push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    }
  }
  constexpr float kLeaf = static_cast<float>(kSize);
  for (auto _ : state) {  // all points at once: it cannot take scan after scan
    pcl::VoxelGrid<pcl::PointXYZ> filter;
    pcl::PointCloud<pcl::PointXYZ> out;
    filter.setInputCloud(cloud);
    filter.setLeafSize(kLeaf, kLeaf, kLeaf);
    filter.filter(out);
    benchmark::DoNotOptimize(out.size());
  }
  count_ops(state);
}
BENCHMARK(voxel_pcl)->Name("voxel_insert/pcl::VoxelGrid, all at once");
#else
[[maybe_unused]] const int kNoPcl =
    bench::skip_peer("pcl::VoxelGrid", "not installed; apt-get install libpcl-dev");
#endif

}  // namespace
