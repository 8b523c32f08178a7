// SPDX-License-Identifier: BSD-3-Clause
// Ways through a large hall beside lazy Theta* over all of its voxels: run time, length, memory.
#include <algorithm>
#include <ctime>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "planner/uav_path/sight.hpp"
#include "tests/bench/uav/uav_parts.hpp"
#include "tests/planner/path_rig.hpp"

namespace sortie::bench {
namespace {

using planner::FlightMap;
using planner::Voxel3;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

float apart(const Voxel3& a, const Voxel3& b) {
  return planner::distance(planner::to_point(a), planner::to_point(b));
}

// Lazy Theta* (Nash et al. 2010) at full resolution: length in voxels, negative where there is no way.
float lazy_theta(const FlightMap& map, const Voxel3& start, const Voxel3& goal) {
  const std::int32_t nx = map.config().nx;
  const std::int32_t ny = map.config().ny;
  const auto index = [&](const Voxel3& v) { return static_cast<std::size_t>(v.x + nx * (v.y + ny * v.z)); };
  const auto voxel = [&](std::size_t i) {
    const auto n = static_cast<std::int32_t>(i);
    return Voxel3{n % nx, n / nx % ny, n / (nx * ny)};
  };
  const std::size_t all = index({0, 0, map.config().nz});
  std::vector<float> length(all, 1e30f);
  std::vector<std::size_t> parent(all);
  std::vector<char> closed(all);
  using Entry = std::pair<float, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  length[index(start)] = 0.0f;
  parent[index(start)] = index(start);
  open.push({apart(start, goal), index(start)});
  while (!open.empty()) {
    const std::size_t i = open.top().second;
    open.pop();
    if (closed[i] != 0) continue;
    const Voxel3 v = voxel(i);
    const auto for_each_near = [&](auto visit) {
      for (int n = 0; n < 27; ++n) {
        const Voxel3 near{v.x + n % 3 - 1, v.y + n / 3 % 3 - 1, v.z + n / 9 - 1};
        if (n != 13 && map.is_free(near)) visit(near, index(near));
      }
    };
    if (parent[i] != i && !planner::line_is_free(map, voxel(parent[i]), v)) {
      length[i] = 1e30f;
      for_each_near([&](const Voxel3& near, std::size_t j) {
        if (closed[j] == 0 || !(length[j] + apart(near, v) < length[i])) return;
        length[i] = length[j] + apart(near, v);
        parent[i] = j;
      });
    }
    closed[i] = 1;
    if (v == goal) return length[i];
    const Voxel3 from = voxel(parent[i]);
    for_each_near([&](const Voxel3& near, std::size_t j) {
      const float sum = length[parent[i]] + apart(from, near);
      if (closed[j] != 0 || !(sum < length[j] - 1e-6f)) return;
      length[j] = sum;
      parent[j] = parent[i];
      open.push({sum + apart(near, goal), j});
    });
  }
  return -1.0f;
}

}  // namespace

void measure_uav_paths(const UavSettings&, Report& report) {
  namespace rig = planner::test;
  Rounds ours;
  Rounds theirs;
  Rounds lengths;
  std::size_t bytes = 0;
  for (std::uint32_t seed = 1; seed <= 2; ++seed) {
    rig::OwnedMap owned(rig::cube(200, 200, 40, 0.3, 0.15));
    rig::build_hall(owned.map, seed, 4, 150);
    rig::OwnedPath memory(owned.map);
    bytes = memory.bytes() + owned.blocked.size() * 16 + owned.dirty.size() * 8;
    std::mt19937 random(seed);
    for (int question = 0; question < 10; ++question) {
      const Voxel3 start = rig::any_free(owned.map, random, 0, 30);
      const Voxel3 goal = rig::any_free(owned.map, random, 170, 200);
      const double before = cpu_ms();
      planner::PathState state =
          memory.path.begin(owned.map, owned.map.middle_m(start), owned.map.middle_m(goal));
      while (state == planner::PathState::running || state == planner::PathState::found)
        state = memory.path.step(owned.map, 1000);
      const double middle = cpu_ms();
      const float judged = lazy_theta(owned.map, start, goal);
      theirs.add(cpu_ms() - middle);
      ours.add(middle - before);
      if (judged > 0)
        lengths.add(memory.path.length_m() / owned.map.config().voxel_m / static_cast<double>(judged));
    }
  }
  Figure time;
  time.group = "paths";
  time.what = "a way through 1.6 million voxels";
  time.unit = "ms";
  time.n = ours.size();
  time.ours = spread(ours);
  time.peer = "lazy Theta* over all voxels";
  time.theirs = spread(theirs);
  time.ratio = spread(ratio(ours, theirs));
  report.add(time);
  double sum = 0.0;
  for (const double ms : ours.values()) sum += ms;
  add_limit(report, "paths", "mean time", "ms", sum / static_cast<double>(ours.size()), 15.0);
  add_limit(report, "paths", "longest time", "ms", ours.high(), 25.0);
  add_limit(report, "paths", "length over lazy Theta*, worst", "", lengths.high(), 1.05);
  add_limit(report, "paths", "memory with the map", "MB", 1e-6 * static_cast<double>(bytes), 4.0);
}

}  // namespace sortie::bench
