// SPDX-License-Identifier: BSD-3-Clause
// What parts of the group `mapping` let later parts of it see. A task of the same group, behind the owner's
// in the table, may use it in its job.
#pragma once

#include "mapping/elevation/elevation_map.hpp"
#include "mapping/registration/cloud_match.hpp"
#include "mapping/registration/locator.hpp"

namespace sortie::firmware {

/// Offered by `locate`: its locator, to place() the robot with, and the scan of this job.
struct LocateAccess {
  mapping::Locator* locator{};
  mapping::RegistrationMemory memory;
  /// Scans that were looked at in this job. The newest one is the registration's sample, and `hint` is what
  /// the odometry says of it.
  std::uint32_t scans{};
  mapping::OdometryHint hint;
  bool has_odometry{};            ///< `hint` is the odometry's; else where the robot starts
  rt::Quaternion q_level_sensor;  ///< the scan's attitude
};

/// Offered by `cloud`.
struct CloudAccess {
  mapping::SensedCloud cloud;
  std::uint64_t views{};  ///< that are in it
  bool held{};            ///< set by the reader: the cloud stays as it is, views are left out
  bool renew{};           ///< set by the reader: the next job begins with an empty cloud
};

/// Offered by `elevation`.
struct ElevationAccess {
  const mapping::ElevationMap* map{};  ///< in the frame of `locate`, or where there is none the odometry's
};

}  // namespace sortie::firmware
