// SPDX-License-Identifier: BSD-3-Clause
// Maps under the campaign: voxel grid, normals and segments in pools that are too small; occupancy and rays.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "mapping/occupancy/occupancy.hpp"
#include "planner/ray_scheduler.hpp"
#include "tests/bench/campaign/trial.hpp"
#include "tests/bench/campaign/trials.hpp"
#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {

namespace {

// A small patch of points about a place; every fourth operation has an empty scan, a wild point or a long
// scan.
void points_of(const CampaignOp& op, std::vector<rt::ScanPoint>& points) {
  points.clear();
  const auto& v = op.value;
  const std::uint32_t side = op.kind % 4 == 3 ? 0 : 3 + op.kind % 8;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const double a = 0.06 * (i % side);
    const double b = 0.06 * (i / side);
    points.push_back({static_cast<float>(6.0 * v[0] + a), static_cast<float>(6.0 * v[1] + b),
                      static_cast<float>(2.0 * v[2] + v[3] * a), 0, 0});
  }
  if (op.kind % 4 == 2)
    points.push_back({static_cast<float>(v[4]), static_cast<float>(v[5]), static_cast<float>(v[6]), 0, 0});
  if (op.kind % 32 == 17) points.insert(points.end(), 600, {1.0f, 2.0f, 0.0f, 0, 0});
}

mapping::RigidPose pose_of(const CampaignOp& op) {
  const auto& v = op.value;
  const double far = op.kind % 16 == 5 ? 1e4 : 4.0;
  return {{far * v[4], 4.0 * v[5], v[6]}, rt::exp_rotation({0.2 * v[6], 0.2 * v[5], 2.0 * v[4]})};
}

}  // namespace

CampaignOutcome run_grid_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  mapping::RollingGridConfig config;
  config.radius_m = 6.0;
  config.half_height_m = 2.0;
  config.mean_window = !ops.empty() && ops[0].value[6] > 0.0 ? 65535 : 1;
  config.forget_ticks = !ops.empty() && ops[0].value[5] > 0.0 ? 0 : 20;
  config.evict_farthest = ops.empty() || ops[0].value[4] > 0.0;
  mapping::SegmenterConfig segments;
  segments.min_voxels = 4;
  segments.units = !ops.empty() && ops[0].value[3] > 0.0 ? 0 : 200;
  tests::MapSizes sizes;  // too small for what comes
  sizes.blocks = 48;
  sizes.voxels = 512;
  sizes.nodes = 64;
  sizes.points = 512;
  sizes.slots = 24;
  sizes.events = 64;
  tests::SmoothMap owned(config, segments, sizes);
  std::vector<rt::ScanPoint> points;
  points.reserve(1024);
  rt::Tick tick = 0;
  for (const CampaignOp& op : ops) {
    points_of(op, points);
    rt::PointScan scan;
    scan.header.points = static_cast<std::uint32_t>(points.size());
    scan.points = points.data();
    if (op.kind % 16 == 9) {
      trial.given(trial.real_time([&] { return owned.owned.grid.move_grid(pose_of(op)); }));
    }
    const mapping::LocalMapStep step =
        trial.real_time([&] { return owned.map.update(scan, pose_of(op), ++tick); });
    const mapping::RollingGridCounts& c = step.inserted.points;
    const std::uint64_t refused = c.not_finite + c.too_near + c.too_far + c.outside + c.out_of_grid +
                                  c.pool_full + c.scan_full + c.bad_pose;
    trial.need(c.in == points.size(), "points went in that nobody counted");
    trial.count_many(points.size(), c.used, refused);
    const mapping::RollingGridOutput& now = owned.grid().output();
    trial.see(now, "the grid's output is not finite");
    trial.need(now.voxels <= sizes.voxels && now.blocks <= sizes.blocks, "the map is larger than its memory");
    std::uint32_t voxels = 0;
    for (std::uint32_t i = 0; i < owned.grid().block_numbers(); ++i) {
      const auto index = static_cast<mapping::BlockIndex>(i);
      const mapping::Block& block = owned.grid().block(index);
      if (!block.in_use()) continue;
      for (unsigned cell = 0; cell < 64; ++cell) {
        if ((block.active >> cell & 1) == 0) continue;
        ++voxels;
        const rt::Vector3 mean = owned.grid().centroid_m(block, cell);
        trial.need(rt::is_finite(mean), "a voxel's mean is not finite");
        trial.fold(std::bit_cast<std::uint64_t>(mean.x));
        trial.fold(owned.segmenter().segment_of(owned.grid(), index, cell));
      }
    }
    trial.need(voxels == now.voxels, "the count of voxels is not that of the blocks");
    trial.need(step.segments.backlog <= sizes.blocks, "more blocks wait than there are");
  }
  return trial.end();
}

CampaignOutcome run_ray_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  mapping::OccupancyConfig config;
  config.size[0] = config.size[1] = 32;
  config.size[2] = 16;
  config.roll_cells = 4;
  config.max_range_m = 6.0;
  std::vector<std::int8_t> cells(static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(config)));
  mapping::OccupancyMap map(config, cells);
  planner::RaySchedulerConfig rays;
  rays.sensor.columns = 16;
  rays.sensor.rows = 12;
  rays.sensor.range_m = 6.0;
  rays.rays = 12;
  rays.positions = 3;
  rays.map_cells = 32 * 32 * 16;
  rays.table_lines = !ops.empty() && ops[0].value[6] > 0.0 ? 0 : 64;  // a table that fills up
  std::vector<std::byte> memory(static_cast<std::size_t>(planner::RayScheduler::memory_bytes(rays)));
  const auto scheduler = std::make_unique<planner::RayScheduler>(rays, memory);
  trial.need(map.usable() && scheduler->usable(), "the settings are not usable");
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    const rt::Vector3 from{3.0 * v[0], 3.0 * v[1], v[2]};
    const rt::Vector3 to{6.0 * v[3], 6.0 * v[4], 2.0 * v[5]};
    if (op.kind % 8 == 0) {
      trial.given(trial.real_time([&] { return map.centre_on(from); }));
    } else if (op.kind % 8 != 1) {
      trial.given(trial.real_time([&] { return map.update_ray(from, to, op.kind % 2 == 0); }));
      const mapping::OccupancyOutput& now = map.output();
      trial.see(now, "the occupancy's output is not finite");
      trial.need(now.used + now.outside + now.not_finite + now.too_near == now.rays,
                 "rays are not counted each once");
      trial.need(now.known <= map.view().cell_count(), "more cells are known than there are");
    } else {
      const mapping::SensorPose poses[3] = {{from, rt::exp_rotation({0, 0, 3.0 * v[6]})},
                                            {from, rt::exp_rotation({0, 0.2, 3.0 * v[5]})},
                                            {to, {1, 0, 0, 0}}};
      const std::uint32_t some = 1 + whole_of(v[6], 4);
      const std::span<const mapping::SensorPose> given(poses, std::min<std::uint32_t>(some, 3));
      const std::uint32_t passed = v[4] > 0.0 ? whole_of(v[4], 5) : planner::RayScheduler::kNothingPassed;
      if (trial.answered(trial.real_time([&] { return scheduler->begin(map.view(), given, passed); })) !=
          Status::ok)
        continue;
      double worth = 0;
      for (const std::uint64_t units : {0u, 100u, 3000u}) {
        const std::uint64_t spent = trial.real_time([&] { return scheduler->step(units); });
        trial.need(spent <= units + scheduler->largest_step(), "more units were spent than given");
        const planner::RayPlan& plan = scheduler->plan();
        trial.see(plan.worth, "the plan's worth is not finite");
        trial.need(plan.worth >= worth, "more units gave a worse plan");
        worth = plan.worth;
        for (std::uint32_t position = 0; position < given.size(); ++position) {
          trial.need(scheduler->rays(position).size() == 12, "a plan is not complete");
          std::vector<bool> chosen(rays.sensor.rays());
          for (const std::uint16_t ray : scheduler->rays(position)) {
            trial.need(ray < rays.sensor.rays() && !chosen[ray],
                       "a ray is chosen twice, or there is none such");
            if (ray < rays.sensor.rays()) chosen[ray] = true;
            trial.fold(ray);
          }
        }
      }
    }
  }
  return trial.end();
}

}  // namespace sortie::bench
