// SPDX-License-Identifier: BSD-3-Clause
// What the part `locate` lets a later part of its group see: its locator, and the scan of this job.
#pragma once

#include "mapping/registration/locator.hpp"

namespace sortie::firmware {

/// Offered by `locate`. A task of the same group, behind it in the table, may use the locator's registration
/// and place() the robot in its job.
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

}  // namespace sortie::firmware
