// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_ssl_config.hpp"

#include <cmath>

#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {

SensorMount read_ssl_mount(Profile& profile) {
  return read_mount(profile, "ssl", 0.2, "place of the solid-state lidar on the body",
                    "turn of the solid-state lidar on the body");
}

SslSettings read_ssl_settings(Profile& profile) {
  SslSettings settings;
  settings.units = 2'000'000;
  planner::SslChoiceConfig& choice = settings.choice;
  const std::string policy = profile.text("ssl.policy", "scheduled",
                                          "who says which rays are fired: the scheduler over a map, the same "
                                          "even grid, chance, or strides through all directions",
                                          {"scheduled", "grid", "random", "stride"});
  choice.policy = policy == "grid"     ? planner::SslPolicy::grid
                  : policy == "random" ? planner::SslPolicy::random
                  : policy == "stride" ? planner::SslPolicy::stride
                                       : planner::SslPolicy::scheduled;
  choice.scheduler.rays = static_cast<std::uint32_t>(
      profile.integer("ssl.rays", {200, 1, rt::kSslMaxRays, "", "asked for at every release"}));
  choice.seed = static_cast<std::uint64_t>(
      profile.integer("ssl.seed", {1, 0, 4294967295.0, "", "of rays that are chosen by chance"}));
  planner::RaySchedulerConfig& scheduler = choice.scheduler;
  scheduler.positions = static_cast<std::uint32_t>(
      profile.integer("ssl.positions", {1, 1, planner::RayScheduler::kMostPositions, "",
                                        "releases that are planned together, the next one among them"}));
  scheduler.sensor.range_m =
      profile.number("ssl.range_m", {rt::kSslMaxRange_m, 0.5, 65, "m", "rays are planned up to here"});
  scheduler.model.unknown = profile.text("ssl.unknown", "prior",
                                         "behind the first unknown cell a planned ray goes on with the "
                                         "prior, or ends",
                                         {"prior", "stop"}) == "prior"
                                ? planner::UnknownSpace::prior
                                : planner::UnknownSpace::stop;
  return settings;
}

OccupancySettings read_occupancy_settings(Profile& profile) {
  OccupancySettings settings;
  mapping::OccupancyConfig& map = settings.map;
  map.voxel_size_m = profile.number("occupancy.voxel_m", {map.voxel_size_m, 0.02, 2, "m", "edge of a cell"});
  const char* const kKeys[3] = {"occupancy.window_x_m", "occupancy.window_y_m", "occupancy.window_z_m"};
  for (int a = 0; a < 3; ++a) {
    const double metres = profile.number(
        kKeys[a], {0.2 * map.size[a], 0.1, 1000, "m", "size of the window that moves with the robot"});
    map.size[a] = static_cast<std::int32_t>(std::fmax(1.0, std::round(metres / map.voxel_size_m)));
  }
  const NumberSpec chance{0, 0.001, 0.999, "", ""};
  const auto probability = [&](const char* path, double fallback, const char* meaning) {
    NumberSpec spec = chance;
    spec.fallback = fallback;
    spec.meaning = meaning;
    return profile.number(path, spec);
  };
  map.prior = probability("occupancy.prior", map.prior, "that an unknown cell is occupied");
  map.hit = probability("occupancy.hit", map.hit, "what a return says about its cell");
  map.miss = probability("occupancy.miss", map.miss, "what a passing ray says about a cell");
  map.min_range_m =
      profile.number("occupancy.min_range_m", {map.min_range_m, 0, 100, "m", "nearer returns are refused"});
  map.max_range_m = profile.number(
      "occupancy.max_range_m", {map.max_range_m, 0.1, 1000, "m", "farther returns only free what is nearer"});
  settings.scan_stride = static_cast<std::uint32_t>(
      profile.integer("occupancy.scan_stride",
                      {1, 1, 1024, "", "each so many-th return of a scan is entered, if there is a lidar"}));
  settings.silent_free_m = profile.number(
      "occupancy.silent_free_m", {map.max_range_m, 0, 1000, "m",
                                  "a ray without a return frees the cells up to here; 0: it says nothing"});
  settings.max_pose_age_ns = milliseconds(profile.number(
      "occupancy.max_pose_age_ms",
      {100, 0, 1e4, "ms", "what was measured this long after the newest pose is placed there"}));
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
