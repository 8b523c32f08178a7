// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/sensor_mount.hpp"

namespace sortie::firmware {

SensorMount read_mount(Profile& profile, const std::string& table, double usual_x_m, const char* place,
                       const char* turn) {
  SensorMount mount;
  mount.place_m[0] = usual_x_m;
  mount.place = place;
  mount.turn = turn;
  profile.read(table, mount);
  return mount;
}

SensorMount read_lidar_mount(Profile& profile) {
  return read_mount(profile, "lidar", 0.05, "place of the lidar on the body",
                    "turn of the lidar on the body");
}

}  // namespace sortie::firmware
