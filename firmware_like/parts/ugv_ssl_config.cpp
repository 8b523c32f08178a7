// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_ssl_config.hpp"

#include <cmath>

namespace sortie::firmware {

SslSettings read_ssl_settings(Profile& profile) {
  SslSettings settings;
  settings.units = 2'000'000;
  settings.choice.scheduler.positions = 1;
  settings.choice.scheduler.sensor.range_m = rt::kSslMaxRange_m;
  profile.read("ssl", settings.choice);
  return settings;
}

OccupancySettings read_occupancy_settings(Profile& profile) {
  mapping::WrittenOccupancy written;
  profile.read("occupancy", written);
  OccupancySettings settings;
  mapping::OccupancyConfig& map = settings.map = written.map;
  for (int a = 0; a < 3; ++a) {
    map.size[a] =
        static_cast<std::int32_t>(std::fmax(1.0, std::round(written.window_m[a] / map.voxel_size_m)));
  }
  settings.silent_free_m = map.max_range_m;
  profile.read<OccupancyUse>("occupancy", settings);
  const std::uint64_t cells = mapping::OccupancyMap::memory_bytes(map);
  if (cells > (1u << 24) || map.size[0] > 4096 || map.size[1] > 4096 || map.size[2] > 4096)
    profile.fail("occupancy.voxel_m", "the window has " + std::to_string(cells) +
                                          " cells; at most 16777216, and 4096 along an axis");
  if (map.max_range_m <= map.min_range_m)
    profile.fail("occupancy.max_range_m", "must be above occupancy.min_range_m");
  return settings;
}

OccupancySettings read_occupancy_settings(Profile& profile, SslSettings& ssl) {
  OccupancySettings settings = read_occupancy_settings(profile);
  const mapping::OccupancyConfig& map = settings.map;
  planner::RaySchedulerConfig& scheduler = ssl.choice.scheduler;
  scheduler.voxel_size_m = map.voxel_size_m;
  scheduler.map_cells = mapping::OccupancyMap::memory_bytes(map);
  scheduler.model.prior = map.prior;
  if (planner::RayScheduler::memory_bytes(scheduler) == 0)
    profile.fail("ssl.range_m", "too many cells of occupancy.voxel_m along one ray");
  return settings;
}

}  // namespace sortie::firmware
