// SPDX-License-Identifier: BSD-3-Clause
// The solid-state lidar's and its map's part of a scene profile.
#pragma once

#include "firmware_like/parts/sensor_mount.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "mapping/occupancy/occupancy.hpp"
#include "planner/ssl_choice.hpp"

namespace sortie::firmware {

/// Where the solid-state lidar sits on the body: [ssl].
inline SensorMount read_ssl_mount(Profile& profile) {
  return read_mount(profile, "ssl", 0.2, "place of the solid-state lidar on the body",
                    "turn of the solid-state lidar on the body");
}

/// What task `ssl` is built with.
struct SslSettings {
  planner::SslChoiceConfig choice;
  std::uint32_t units{};  ///< of one execution where the profile says nothing else
};

/// What is entered into the map.
struct OccupancyUse {
  std::uint32_t scan_stride{1};  ///< each so many-th return of a scan is entered
  double silent_free_m{};        ///< a ray without a return frees the cells up to here
  rt::Nanoseconds max_pose_age_ns{100 * rt::kNanosecondsPerMillisecond};

  SORTIE_KEYS(c, key) {
    key("scan_stride", c.scan_stride,
        {1, 1024, "", "each so many-th return of a scan is entered, if there is a lidar"});
    key("silent_free_m", c.silent_free_m,
        {0, 1000, "m", "a ray without a return frees the cells up to here; 0: it says nothing"});
    key("max_pose_age_ms", c.max_pose_age_ns,
        {0, 1e4, rt::kMsInNs, "what was measured this long after the newest pose is placed there"});
  }
};

/// The map that the scheduler looks at.
struct OccupancySettings : OccupancyUse {
  mapping::OccupancyConfig map;
};

/// Reader of [ssl]. Throws ProfileError.
SslSettings read_ssl_settings(Profile& profile);

/// Reader of [occupancy] alone. Throws ProfileError.
OccupancySettings read_occupancy_settings(Profile& profile);

/// Reader of [occupancy]; completes the scheduler's settings with those of the map. Throws ProfileError. Keys
/// hold for every policy, so that another one may be tried with a single `--set`.
OccupancySettings read_occupancy_settings(Profile& profile, SslSettings& ssl);

}  // namespace sortie::firmware
