// SPDX-License-Identifier: BSD-3-Clause
// Ways through a large hall beside lazy Theta* over all of its voxels: run time, length, memory.
#include <algorithm>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "planner/uav_path/sight.hpp"
#include "tests/bench/uav/ompl_ways.hpp"
#include "tests/bench/uav/pilot_cost.hpp"
#include "tests/bench/uav/uav_parts.hpp"
#include "tests/planner/path_rig.hpp"

namespace sortie::bench {
namespace {

using planner::FlightMap;
using planner::Voxel3;

constexpr std::uint64_t kSliceUnits = 500;

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

// All questions, all ways.
struct WayRounds {
  Rounds ours_ms;
  Rounds slice_ms;  ///< the longest of each question
  Rounds full_ms;
  Rounds rrt_ms;
  Rounds over_full;  ///< length over that of lazy Theta*
  Rounds under_rrt;  ///< how much shorter than RRT-Connect, share
  double failed{};   ///< of the peer
  std::size_t bytes{};
};

void add_ways(Report& report, const char* peer, const Rounds& ours, const Rounds& theirs, const char* goal,
              bool met) {
  Figure time;
  time.group = "paths";
  time.what = "a way through 1.6 million voxels";
  time.unit = "ms";
  time.n = ours.size();
  time.ours = spread(ours);
  time.peer = peer;
  time.theirs = spread(theirs);
  time.ratio = spread(ratio(ours, theirs));
  if (goal[0] != 0) set_goal(time, goal, met);
  report.add(time);
}

double mean(const Rounds& rounds) {
  double sum = 0.0;
  for (const double value : rounds.values()) sum += value;
  return sum / static_cast<double>(rounds.size());
}

void ask(const FlightMap& map, planner::UavPath& path, const Voxel3& start, const Voxel3& goal,
         WayRounds& rounds) {
  double worst_slice = 0.0;
  const double before = cpu_us();
  double last = before;
  planner::PathState state = path.begin(map, map.middle_m(start), map.middle_m(goal));
  while (state == planner::PathState::running || state == planner::PathState::found) {
    state = path.step(map, kSliceUnits);
    const double now = cpu_us();
    worst_slice = std::max(worst_slice, now - last);
    last = now;
  }
  rounds.ours_ms.add(1e-3 * (last - before));
  rounds.slice_ms.add(1e-3 * worst_slice);
  const double middle = cpu_us();
  const float judged = lazy_theta(map, start, goal);
  rounds.full_ms.add(1e-3 * (cpu_us() - middle));
  if (judged > 0) rounds.over_full.add(path.length_m() / map.config().voxel_m / static_cast<double>(judged));
  if (!ompl_missing().empty()) return;
  const PeerWay way = ompl_way(map, start, goal);
  if (way.found) {
    rounds.rrt_ms.add(way.ms);
    rounds.under_rrt.add(1.0 - path.length_m() / way.length_m);
  } else {
    rounds.failed += 1.0;
  }
}

}  // namespace

void measure_uav_paths(const UavSettings&, Report& report) {
  namespace rig = planner::test;
  WayRounds rounds;
  seed_ompl(1);
  for (std::uint32_t seed = 1; seed <= 2; ++seed) {
    rig::OwnedMap owned(rig::cube(200, 200, 40, 0.3, 0.15));
    rig::build_hall(owned.map, seed, 4, 150);
    rig::OwnedPath memory(owned.map);
    rounds.bytes = memory.bytes() + owned.blocked.size() * 16 + owned.dirty.size() * 8;
    std::mt19937 random(seed);
    for (int question = 0; question < 10; ++question) {
      const Voxel3 start = rig::any_free(owned.map, random, 0, 30);
      const Voxel3 goal = rig::any_free(owned.map, random, 170, 200);
      ask(owned.map, memory.path, start, goal, rounds);
    }
  }
  add_ways(report, "lazy Theta* over all voxels", rounds.ours_ms, rounds.full_ms, "", true);
  if (rounds.rrt_ms.empty()) {
    report.skip("RRT-Connect beside the ways", ompl_missing());
  } else {
    add_ways(report, "OMPL RRTConnect, mean of both compared", rounds.ours_ms, rounds.rrt_ms, "faster",
             mean(rounds.ours_ms) < mean(rounds.rrt_ms));
    Figure shorter{"paths",
                   "shorter than RRTConnect, all ways",
                   "%",
                   rounds.under_rrt.size(),
                   spread(100.0 * mean(rounds.under_rrt)),
                   {},
                   {},
                   {},
                   {},
                   {}};
    set_goal(shorter, ">= 20 %", mean(rounds.under_rrt) >= 0.2);
    report.add(shorter);
    report.add_table("paths", {"planner", "ways of 20", "mean ms", "longest ms"},
                     {{"ours", rounds.ours_ms.size(), mean(rounds.ours_ms), rounds.ours_ms.high()},
                      {"OMPL RRTConnect", rounds.rrt_ms.size(), mean(rounds.rrt_ms), rounds.rrt_ms.high()},
                      {"lazy Theta*", rounds.over_full.size(), mean(rounds.full_ms), rounds.full_ms.high()}});
    report.note("paths", ompl_settings());
  }
  add_limit(report, "paths", "mean time", "ms", mean(rounds.ours_ms), 15.0);
  add_limit(report, "paths", "longest time", "ms", rounds.ours_ms.high(), 25.0);
  add_limit(report, "paths", "longest slice of 500 units", "ms", rounds.slice_ms.high(), 1.0);
  add_limit(report, "paths", "length over lazy Theta*, worst", "", rounds.over_full.high(), 1.05);
  add_limit(report, "paths", "memory with the map", "MB", 1e-6 * static_cast<double>(rounds.bytes), 4.0);
}

}  // namespace sortie::bench
