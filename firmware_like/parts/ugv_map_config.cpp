// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_map_config.hpp"

#include <algorithm>

#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {
namespace {

constexpr double kMostCells = 4;  // that a neighbourhood reaches

mapping::RollingGridConfig read_grid(Profile& profile) {
  mapping::RollingGridConfig c;
  c.max_range_m = 30;
  profile.read("map", c);
  if (c.max_range_m <= c.min_range_m) profile.fail("map.max_range_m", "must be above map.min_range_m");
  for (const char* path : {"map.radius_m", "map.half_height_m"}) {
    const double cells = (path[4] == 'r' ? c.radius_m : c.half_height_m) / c.voxel_size_m;
    if (cells < 4 || cells > 1000) profile.fail(path, "must be 4 to 1000 voxels (map.voxel_m)");
  }
  return c;
}

void read_segments(Profile& profile, ChosenMapConfig& c) {
  const double edge_m = c.grid.voxel_size_m;
  c.by = SegmentsBy::euclidean;
  c.segments.radius_m = 2 * edge_m;
  c.most_segments = 1024;
  c.normals.radius_m = 3 * edge_m;
  c.normals.restate_m = 0.3 * edge_m;
  c.most_angle_rad = 4 * kDegree;
  c.voxels = 1 << 17;
  profile.read("map", c);
  const auto check = [&](const char* path, double radius_m) {
    if (radius_m > kMostCells * edge_m) profile.fail(path, "must be at most 4 voxels (map.voxel_m)");
  };
  check("map.growing_radius_m", c.segments.radius_m);
  check("map.normal_radius_m", c.normals.radius_m);
  c.voxels = c.voxels / 4 * 4;
  if (c.blocks == 0) c.blocks = std::min(c.voxels / 4, 65'534u);
}

/// Body frame: x forward, y left, z up, origin on the ground between the tracks.
mapping::SelfFilterConfig read_outline(Profile& profile) {
  mapping::SelfFilterConfig c;
  c.margin_m = profile.number("outline.margin_m",
                              {c.margin_m, 0, 1, "m", "as far from the robot a return still is the robot"});
  const char* meaning = "least x, y, z and most x, y, z of the body in its own frame; all 0: no such part";
  for (const char* path : {"outline.body_m", "outline.tracks_m"}) {
    const std::vector<double> b =
        profile.numbers(path, std::vector<double>(6, 0.0), {0, -10, 10, "m", meaning});
    meaning = "the same of all between and with the tracks";
    if (std::all_of(b.begin(), b.end(), [](double value) { return value == 0.0; })) continue;
    if (!(b[0] < b[3] && b[1] < b[4] && b[2] < b[5])) profile.fail(path, "the most must be above the least");
    mapping::BodyBox& box = c.boxes[c.box_count++];
    box.centre_m = {0.5 * (b[0] + b[3]), 0.5 * (b[1] + b[4]), 0.5 * (b[2] + b[5])};
    box.half_m = {0.5 * (b[3] - b[0]), 0.5 * (b[4] - b[1]), 0.5 * (b[5] - b[2])};
  }
  c.flippers.large_radius_m = 0.1;
  c.flippers.small_radius_m = c.flippers.half_width_m = 0.03;
  profile.read("outline", c.flippers);
  if (c.flippers.length_m == 0.0) c.flippers = {};
  if (mapping::SelfFilter(c).usable() != Status::ok)
    profile.fail("outline.flipper_length_m", "one wheel of the flipper would hold the other");
  return c;
}

}  // namespace

mapping::SweepConfig read_sweep_config(Profile& profile) {
  mapping::SweepConfig sweep;
  const SensorMount mount = read_lidar_mount(profile);
  sweep.p_body_sensor_m = rt::to_vector(mount.place_m);
  sweep.q_body_sensor = mount.q_body_sensor();
  profile.read("map", sweep);
  sweep.robot = read_outline(profile);
  return sweep;
}

UgvMapConfig read_map_config(Profile& profile) {
  profile.knob("groups.mapping.rate_hz");
  UgvMapConfig config;
  ChosenMapConfig& map = config.map;
  map.grid = read_grid(profile);
  read_segments(profile, map);
  ScanLimits scans;
  profile.read("limits", scans);
  config.scan_buffers = scans.buffers;
  map.scan_points = scans.points;
  config.sweep = read_sweep_config(profile);
  config.sweep.min_range_m = map.grid.min_range_m;
  config.sweep.max_range_m = map.grid.max_range_m;
  const std::string publish = profile.text("map.publish", "segments",
                                           "of segments, over LCM: nothing; ids, sizes and events; or also "
                                           "places, boxes and features of their eigenvalues",
                                           {"off", "segments", "features"});
  config.publish = publish != "off" && map.by != SegmentsBy::off;
  config.features = config.publish && publish == "features";
  config.anytime = profile.flag("map.anytime", false, "segments wait when the units of task map are spent") &&
                   map.by != SegmentsBy::off;
  return config;
}

}  // namespace sortie::firmware
