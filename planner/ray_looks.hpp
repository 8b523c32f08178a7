// SPDX-License-Identifier: BSD-3-Clause
// What was found out about each direction of a task, and what looking again takes.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/sensor_pose.hpp"
#include "mapping/occupancy/occupancy_view.hpp"
#include "planner/ray_config.hpp"
#include "planner/ray_cover.hpp"
#include "planner/ray_model.hpp"
#include "planner/ray_path.hpp"

namespace sortie::planner {

/// Memory of RayLooks, value-initialised. `all`: positions * N.
struct RayLooksMemory {
  std::span<rt::SinCos> columns;
  std::span<rt::SinCos> rows;
  std::span<rt::Vector3> across;    ///< positions * columns: the horizontal part of directions, turned
  std::span<float> fresh;           ///< all
  std::span<std::uint32_t> traced;  ///< bits, all
  std::span<std::uint32_t> path;    ///< all
  std::span<std::uint32_t> words;   ///< of paths
};

/// The directions of a few sensor poses over a map. Each is traced once; then its worth beside no other ray
/// is known, and mostly its path. Rays are numbered position * N + ray. What returns a number costs as many
/// units. Deterministic, no heap.
class RayLooks {
 public:
  explicit RayLooks(const RaySchedulerConfig& config)
      : sensor_(config.sensor), model_(config.model), all_rays_(config.sensor.rays()) {}
  /// Start-up only. `most_cells`: of a ray.
  void lay_out(const RayLooksMemory& memory, std::uint32_t most_cells);

  /// A new task; all that was known is forgotten. The map must not change until it is over.
  void begin(const mapping::OccupancyView& map, std::span<const mapping::SensorPose> poses);

  /// Traces a direction for the first time. `beside`: its worth beside these rays is wanted, too.
  std::uint32_t trace(std::uint32_t ray, const RayCover* beside, float& worth);
  /// A traced ray's worth beside others.
  std::uint32_t evaluate(std::uint32_t ray, const RayCover& beside, float& worth);
  /// Enters a traced ray, if the cover takes it.
  std::uint32_t enter(std::uint32_t ray, RayCover& cover, RayWorth& worth, bool& entered);

  bool is_traced(std::uint32_t ray) const { return traced_.has(ray); }
  /// Of a traced ray: its worth beside no other.
  float fresh(std::uint32_t ray) const { return memory_.fresh[ray]; }
  std::uint32_t position_of(std::uint32_t ray) const { return ray / all_rays_; }
  /// False for a pose out of the window: its rays are worth nothing.
  bool is_inside(std::uint32_t position) const { return views_[position].inside; }
  std::uint32_t positions() const { return positions_; }
  /// Directions traced, and worths computed beside other rays, in this task.
  std::uint32_t traced() const { return traced_count_; }
  std::uint32_t evaluations() const { return evaluations_; }

  const RayModel& model() const { return model_; }
  mapping::VoxelWalk walk(std::uint32_t position, std::uint32_t ray) const;

 private:
  // A position's pose in the window.
  struct View {
    rt::Vector3 u;
    rt::Vector3 up;
    std::uint32_t cell{};  // where it is
    bool inside{};
  };
  mapping::VoxelWalk walk(std::uint32_t ray) const { return walk(ray / all_rays_, ray % all_rays_); }
  RayPath path(std::uint32_t ray) const {
    return paths_.path(memory_.path[ray], views_[ray / all_rays_].cell);
  }

  RaySensor sensor_;
  RayModel model_;
  std::uint32_t all_rays_;
  std::uint32_t most_cells_{};
  RayLooksMemory memory_;
  RayBits traced_;
  RayPaths paths_;
  mapping::OccupancyView map_;
  View views_[RaySizes::kMostPositions];
  std::uint32_t positions_{};
  std::uint32_t traced_count_{};
  std::uint32_t evaluations_{};
};

}  // namespace sortie::planner
