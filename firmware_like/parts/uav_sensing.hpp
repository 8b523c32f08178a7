// SPDX-License-Identifier: BSD-3-Clause
// The multirotor's lidar and the map of cells that it fills.
#pragma once

#include <functional>
#include <memory>

#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/ugv_ssl_config.hpp"
#include "mapping/grid/pose_history.hpp"

namespace sortie::firmware {

/// Task `occupancy`: scans are entered into a window that moves with the vehicle, each point from where the
/// lidar was when it was fired, by estimated poses. Readers of the map are in the same group.
class UavSensing {
 public:
  /// Reads [occupancy], [lidar] and the pools of scans, declares stream and task. Until `asked` says that
  /// there was a question for a way, unknown cells within an ellipsoid of `bubble_m` around the vehicle count
  /// as free. Throws ProfileError.
  UavSensing(VehicleBuilder& builder, rt::GroupId group, std::function<bool()> asked,
             const rt::Vector3& bubble_m);

  drivers::ScanSink* scan_sink() { return port_; }
  const mapping::OccupancyMap& map() const { return *map_; }

 private:
  void take_poses(rt::Input<rt::PoseEstimate>& poses);
  void clear_bubble();
  void enter(const rt::PointScan& scan);

  OccupancySettings settings_;
  rt::Vector3 p_body_lidar_;
  rt::Quaternion q_body_lidar_;
  rt::Vector3 bubble_m_;
  ScanStream* scans_{};
  ScanPort* port_{};
  std::unique_ptr<mapping::OccupancyMap> map_;
  std::unique_ptr<mapping::PoseHistory> history_;
  rt::PoseEstimate newest_{};  // its stamp 0: none yet
  std::uint64_t scans_entered_{};
  std::uint64_t points_unplaced_{};
};

}  // namespace sortie::firmware
