// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/sensor_mount.hpp"

#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {

SensorMount read_mount(Profile& profile, const std::string& table, double usual_x_m, const char* place,
                       const char* turn) {
  SensorMount mount;
  mount.place_m[0] = profile.number(table + ".x_m", {usual_x_m, -10, 10, "m", place});
  mount.place_m[1] = profile.number(table + ".y_m", {0, -10, 10, "m", place});
  mount.place_m[2] = profile.number(table + ".z_m", {0.45, -10, 10, "m", place});
  mount.yaw_pitch_roll_rad[0] = profile.number(table + ".yaw_deg", {0, -360, 360, "deg", turn}) * kDegree;
  mount.yaw_pitch_roll_rad[1] = profile.number(table + ".pitch_deg", {0, -90, 90, "deg", turn}) * kDegree;
  mount.yaw_pitch_roll_rad[2] = profile.number(table + ".roll_deg", {0, -180, 180, "deg", turn}) * kDegree;
  return mount;
}

SensorMount read_lidar_mount(Profile& profile) {
  return read_mount(profile, "lidar", 0.05, "place of the lidar on the body",
                    "turn of the lidar on the body");
}

}  // namespace sortie::firmware
