// SPDX-License-Identifier: BSD-3-Clause
// The rays of the next position over the entropy of the map, seen from above.
#include "tests/bench/rays/ray_parts.hpp"
#include "tests/planner/ray_scenes.hpp"

namespace sortie::bench {

void measure_ray_picture(const RaySettings&, Report& report) {
  constexpr std::int32_t kBlock = 4;
  planner::RaySchedulerConfig config;
  config.positions = 1;
  tests::RayMap map;
  tests::make_street(map, 1, config.sensor, true);
  const mapping::OccupancyView view = map.map.view();
  const tests::Street street(map.map.config().size, 1);
  const mapping::SensorPose pose = tests::street_pose(street, view, 0);
  tests::OwnedScheduler owned(config);
  (void)owned.scheduler.begin(view, std::span(&pose, 1));
  while (!owned.scheduler.done()) (void)owned.scheduler.step(1'000'000);
  const planner::RayModel& model = owned.scheduler.model();
  Json blocks = Json::array();
  for (std::int32_t y = 0; y < view.size[1]; y += kBlock) {
    for (std::int32_t x = 0; x < view.size[0]; x += kBlock) {
      double sum = 0;
      for (std::int32_t z = 0; z < view.size[2]; ++z) {
        for (std::int32_t i = 0; i < kBlock * kBlock; ++i)
          sum += model.entropy(mapping::cell_code(
              view.cells[(z * view.size[1] + y + i / kBlock) * view.size[0] + x + i % kBlock]));
      }
      blocks.push_back({view.voxel_size_m * (x + kBlock / 2 + view.low[0]),
                        view.voxel_size_m * (y + kBlock / 2 + view.low[1]),
                        sum / (kBlock * kBlock * view.size[2])});
    }
  }
  Json rays = Json::array();
  for (const std::uint16_t ray : owned.scheduler.rays(0)) {
    mapping::VoxelWalk walk = owned.scheduler.walk(0, ray);
    double visible = 1;
    do visible *= model.passes(mapping::cell_code(view.cells[walk.index]));
    while (visible >= 0.1 && walk.step());  // to where nine of ten such rays have ended
    const auto index = static_cast<std::int32_t>(walk.index);
    rays.push_back({view.voxel_size_m * (index % view.size[0] + view.low[0] + 0.5),
                    view.voxel_size_m * (index / view.size[0] % view.size[1] + view.low[1] + 0.5)});
  }
  report.root()["ray_picture"] = {
      {"from", {pose.p_world_sensor_m.x, pose.p_world_sensor_m.y}}, {"blocks", blocks}, {"rays", rays}};
}

}  // namespace sortie::bench
