// SPDX-License-Identifier: BSD-3-Clause
// Where a sensor sits on the body, as a profile says it.
#pragma once

#include <string>

#include "firmware_like/scene/profile.hpp"

namespace sortie::firmware {

/// T_body_sensor.
struct SensorMount {
  double place_m[3]{};
  double yaw_pitch_roll_rad[3]{};
};

/// Reads x_m, y_m, z_m, yaw_deg, pitch_deg and roll_deg of a table such as "lidar"; `place` and `turn` say in
/// the list of keys what they are. Throws ProfileError.
SensorMount read_mount(Profile& profile, const std::string& table, double usual_x_m, const char* place,
                       const char* turn);

/// Where the lidar sits on the body: [lidar]. Throws ProfileError.
SensorMount read_lidar_mount(Profile& profile);

}  // namespace sortie::firmware
