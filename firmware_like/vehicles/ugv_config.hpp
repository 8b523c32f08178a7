// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's part of a scene profile: every key with unit, range, default and meaning.
#pragma once

#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "firmware_like/vehicle.hpp"
#include "firmware_like/vehicles/sensor_mount.hpp"
#include "mapping/voxel_grid.hpp"
#include "rt/rotation.hpp"

namespace sortie::firmware {

/// Map, its pools, and where the lidar sits.
struct MapConfig {
  mapping::VoxelGridConfig grid;
  std::uint32_t voxels{};
  std::uint32_t scan_buffers{};
  std::uint32_t scan_points{};
  rt::Vector3 p_body_sensor;
  rt::Quaternion q_body_sensor;
  rt::Nanoseconds max_pose_age_ns{};
};

/// Where the lidar sits on the body: [lidar].
SensorMount read_lidar_mount(Profile& profile);

/// Readers of [attitude], [odometry], and [map] with [limits]. Throw ProfileError.
estimators::AttitudeConfig read_attitude_config(VehicleBuilder& builder);
estimators::TrackOdometryConfig read_odometry_config(VehicleBuilder& builder);
MapConfig read_map_config(VehicleBuilder& builder);

}  // namespace sortie::firmware
