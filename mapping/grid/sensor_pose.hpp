// SPDX-License-Identifier: BSD-3-Clause
// Where a sensor was when it looked.
#pragma once

#include "rt/rotation.hpp"

namespace sortie::mapping {

/// T_world_sensor.
struct SensorPose {
  rt::Vector3 p_world_sensor_m;
  rt::Quaternion q_world_sensor;
};

}  // namespace sortie::mapping
