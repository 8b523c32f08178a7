// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ray_looks.hpp"

#include "planner/ray_units.hpp"

namespace sortie::planner {

void RayLooks::lay_out(const RayLooksMemory& memory, std::uint32_t most_cells) {
  most_cells_ = most_cells;
  memory_ = memory;
  traced_ = RayBits(memory.traced);
  paths_ = RayPaths(memory.words);
  for (std::uint32_t i = 0; i < sensor_.columns; ++i)
    memory_.columns[i] = ray_angle(i, sensor_.columns, sensor_.width_rad);
  for (std::uint32_t i = 0; i < sensor_.rows; ++i)
    memory_.rows[i] = ray_angle(i, sensor_.rows, sensor_.height_rad);
}

void RayLooks::begin(const mapping::OccupancyView& map, std::span<const mapping::SensorPose> poses) {
  map_ = map;
  positions_ = static_cast<std::uint32_t>(poses.size());
  traced_count_ = 0;
  evaluations_ = 0;
  for (std::uint32_t p = 0; p < positions_; ++p) {
    const rt::Quaternion q = normalised(poses[p].q_world_sensor);
    View& view = views_[p];
    view.u = map_.to_window(poses[p].p_world_sensor_m);
    view.inside = map_.contains(view.u);
    if (view.inside) view.cell = make_walk(map_, view.u, {1, 0, 0}, 0.0).index;
    view.up = rotate(q, {0, 0, 1});
    const rt::Vector3 forward = rotate(q, {1, 0, 0});
    const rt::Vector3 left = rotate(q, {0, 1, 0});
    for (std::uint32_t i = 0; i < sensor_.columns; ++i)
      memory_.across[p * sensor_.columns + i] =
          memory_.columns[i].cos * forward + memory_.columns[i].sin * left;
  }
  traced_.clear();
  paths_.clear(map.size);
}

mapping::VoxelWalk RayLooks::walk(std::uint32_t position, std::uint32_t ray) const {
  const View& view = views_[position];
  const std::uint32_t row = ray / sensor_.columns;
  const std::uint32_t column = ray - row * sensor_.columns;
  const rt::Vector3 direction = memory_.rows[row].cos * memory_.across[position * sensor_.columns + column] +
                                memory_.rows[row].sin * view.up;
  return make_walk(map_, view.u, direction, sensor_.range_m / map_.voxel_size_m);
}

std::uint32_t RayLooks::trace(std::uint32_t ray, const RayCover* beside, float& worth) {
  ++traced_count_;
  traced_.set(ray);
  memory_.fresh[ray] = 0.0f;
  memory_.path[ray] = 0;
  worth = 0.0f;
  if (!is_inside(ray / all_rays_)) return ray_units::kRay;
  const mapping::VoxelWalk way = walk(ray);
  RayPaths* const kept = paths_.begin(most_cells_) ? &paths_ : nullptr;
  const CoverageTable* const table = beside != nullptr ? &beside->table() : nullptr;
  const RayWorth found = model_.trace(way, map_.cells, table, kept);
  if (kept != nullptr) memory_.path[ray] = paths_.end(way);
  memory_.fresh[ray] = static_cast<float>(found.fresh);
  worth = static_cast<float>(found.current);
  return ray_units::kRay + found.cells * (beside != nullptr ? ray_units::kCellBeside : ray_units::kCell);
}

// Traced in this task, as all rays that are looked at, chosen or weighed: so its path is of this task, too.
std::uint32_t RayLooks::evaluate(std::uint32_t ray, const RayCover& beside, float& worth) {
  worth = 0.0f;
  ++evaluations_;
  if (!is_inside(ray / all_rays_)) return ray_units::kRay;
  const bool kept = memory_.path[ray] > 0;
  const RayWorth found = kept ? model_.current(path(ray), map_.cells, beside.table())
                              : model_.current(walk(ray), map_.cells, beside.table());
  worth = static_cast<float>(found.current);
  return ray_units::kRay + found.cells * (kept ? ray_units::kCellAgain : ray_units::kCellBeside);
}

std::uint32_t RayLooks::enter(std::uint32_t ray, RayCover& cover, RayWorth& worth, bool& entered) {
  entered = memory_.path[ray] > 0 ? cover.enter(ray, model_, path(ray), map_.cells, worth)
                                  : cover.enter(ray, model_, walk(ray), map_.cells, worth);
  return ray_units::kRay + worth.cells * ray_units::kCellTaken;
}

}  // namespace sortie::planner
