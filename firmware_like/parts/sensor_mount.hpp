// SPDX-License-Identifier: BSD-3-Clause
// Where a sensor sits on the body, and how many of its scans may wait, as a profile says it.
#pragma once

#include <string>

#include "firmware_like/scene/profile.hpp"

namespace sortie::firmware {

/// T_body_sensor.
struct SensorMount {
  double place_m[3]{0, 0, 0.45};
  double yaw_pitch_roll_rad[3]{};
  const char* place = "";  ///< meaning of the keys
  const char* turn = "";

  rt::Quaternion q_body_sensor() const {
    return rt::from_yaw_pitch_roll(yaw_pitch_roll_rad[0], yaw_pitch_roll_rad[1], yaw_pitch_roll_rad[2]);
  }

  SORTIE_KEYS(c, key) {
    key("x_m", c.place_m[0], {-10, 10, "m", c.place});
    key("y_m", c.place_m[1], {-10, 10, "m", c.place});
    key("z_m", c.place_m[2], {-10, 10, "m", c.place});
    key("yaw_deg", c.yaw_pitch_roll_rad[0], {-360, 360, rt::kDegInRad, c.turn});
    key("pitch_deg", c.yaw_pitch_roll_rad[1], {-90, 90, rt::kDegInRad, c.turn});
    key("roll_deg", c.yaw_pitch_roll_rad[2], {-180, 180, rt::kDegInRad, c.turn});
  }
};

/// Memory for scans between the lidar and a job.
struct ScanLimits {
  std::uint32_t buffers{4};
  std::uint32_t points{32'768};

  SORTIE_KEYS(c, key) {
    key("scan_buffers", c.buffers, {2, 64, "scans", "pooled buffers; a job takes up to half"});
    key("scan_points", c.points, {1, 1 << 22, "points", "of one scan; a larger one is refused whole"});
  }
};

/// Reads x_m, y_m, z_m, yaw_deg, pitch_deg and roll_deg of a table such as "lidar"; `place` and `turn` say in
/// the list of keys what they are. Throws ProfileError.
inline SensorMount read_mount(Profile& profile, const std::string& table, double usual_x_m, const char* place,
                              const char* turn) {
  SensorMount mount{.place = place, .turn = turn};
  mount.place_m[0] = usual_x_m;
  profile.read(table, mount);
  return mount;
}

/// Where the lidar sits on the body: [lidar]. Throws ProfileError.
inline SensorMount read_lidar_mount(Profile& profile) {
  return read_mount(profile, "lidar", 0.05, "place of the lidar on the body",
                    "turn of the lidar on the body");
}

}  // namespace sortie::firmware
