// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_map_config.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {
namespace {

constexpr double kMostCells = 4;  // that a neighbourhood reaches

std::uint32_t whole(Profile& profile, const std::string& path, const NumberSpec& spec) {
  return static_cast<std::uint32_t>(profile.integer(path, spec));
}

mapping::RollingGridConfig read_grid(Profile& profile) {
  mapping::RollingGridConfig c;
  c.voxel_size_m = profile.number("map.voxel_m", {c.voxel_size_m, 0.01, 10, "m", "edge of a voxel"});
  c.min_range_m =
      profile.number("map.min_range_m", {c.min_range_m, 0, 100, "m", "nearer returns are refused"});
  c.max_range_m = profile.number("map.max_range_m", {30, 0.1, 1000, "m", "farther returns are refused"});
  if (c.max_range_m <= c.min_range_m) profile.fail("map.max_range_m", "must be above map.min_range_m");
  c.radius_m = profile.number(
      "map.radius_m", {c.radius_m, 0.04, 1e4, "m", "of the local map about the sensor, horizontally"});
  c.half_height_m = profile.number(
      "map.half_height_m", {c.half_height_m, 0.04, 1e4, "m", "of the local map, above and below the sensor"});
  for (const char* path : {"map.radius_m", "map.half_height_m"}) {
    const double cells = (path[4] == 'r' ? c.radius_m : c.half_height_m) / c.voxel_size_m;
    if (cells < 4 || cells > 1000) profile.fail(path, "must be 4 to 1000 voxels (map.voxel_m)");
  }
  c.min_points =
      whole(profile, "map.min_points",
            {static_cast<double>(c.min_points), 1, 255, "points", "from which a voxel is part of the map"});
  c.mean_window = whole(profile, "map.mean_window",
                        {static_cast<double>(c.mean_window), 1, 65535, "points",
                         "that a voxel's mean remembers: a small number follows what moved"});
  c.evict_blocks = whole(profile, "map.evict_blocks",
                         {static_cast<double>(c.evict_blocks), 0, 65534, "blocks",
                          "most that a scan may evict by distance or age; 0: no limit"});
  // The map's own ticks are milliseconds.
  c.forget_ticks = static_cast<std::uint32_t>(
      1000 * profile.number("map.forget_s",
                            {0, 0, 1e6, "s", "blocks without a new return for longer go; 0: never"}));
  c.evict_farthest = profile.text("map.when_full", "evict_farthest",
                                  "what happens to points of new voxels when a pool is full",
                                  {"refuse", "evict_farthest"}) == "evict_farthest";
  return c;
}

void read_segments(Profile& profile, ChosenMapConfig& c) {
  const std::string by = profile.text("map.segments", "euclidean", "what makes voxels a segment",
                                      {"off", "euclidean", "smoothness"});
  c.by = by == "off" ? SegmentsBy::off : by == "euclidean" ? SegmentsBy::euclidean : SegmentsBy::smoothness;
  const double edge_m = c.grid.voxel_size_m;
  const auto reach = [&](const char* path, double cells, const char* meaning) {
    const double radius_m = profile.number(path, {cells * edge_m, 0.001, 40, "m", meaning});
    if (radius_m > kMostCells * edge_m) profile.fail(path, "must be at most 4 voxels (map.voxel_m)");
    return radius_m;
  };
  c.segments.radius_m = reach("map.growing_radius_m", 2, "voxels this near are of one segment");
  c.segments.min_voxels = whole(
      profile, "map.min_voxels",
      {static_cast<double>(c.segments.min_voxels), 1, 1e6, "voxels", "from which a segment gets an id"});
  c.most_segments = whole(profile, "limits.segments",
                          {1024, 1, 65534, "segments", "pool of the ids that are in use at a time"});
  c.normals.radius_m = reach("map.normal_radius_m", 3, "neighbourhood of a normal");
  c.normals.restate_m = profile.number(
      "map.restate_m", {0.3 * edge_m, 0, 10, "m", "a voxel that moved farther is added anew to normals"});
  c.normals.solves = whole(profile, "map.solves",
                           {static_cast<double>(c.normals.solves), 0, 1e6, "normals",
                            "most that a scan may compute; 0: no limit"});
  c.most_angle_rad = profile.number("map.most_angle_deg",
                                    {4, 0.1, 60, "deg", "between normals of neighbours in one segment"}) *
                     kDegree;
  c.most_curvature = profile.number(
      "map.most_curvature", {c.most_curvature, 0, 1.0 / 3, "", "of a voxel that a segment grows from"});
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
  mapping::FlipperOutline& f = c.flippers;
  f.length_m = profile.number("outline.flipper_length_m",
                              {0, 0, 10, "m", "from axle to axle; 0: the filter knows no flippers"});
  if (f.length_m == 0.0) return c;
  const std::vector<double> pivot = profile.numbers(
      "outline.flipper_pivot_m", {0, 0, 0},
      {0, -10, 10, "m", "large axle of the front left flipper, body frame; the others mirror it"});
  f.pivot_m = {pivot[0], pivot[1], pivot[2]};
  f.large_radius_m =
      profile.number("outline.flipper_large_radius_m", {0.1, 0, 10, "m", "of the wheel at the pivot"});
  f.small_radius_m =
      profile.number("outline.flipper_small_radius_m", {0.03, 0, 10, "m", "of the wheel at the tip"});
  f.half_width_m = profile.number("outline.flipper_half_width_m", {0.03, 0, 10, "m", "of a flipper"});
  if (mapping::SelfFilter(c).usable() != Status::ok)
    profile.fail("outline.flipper_length_m", "one wheel of the flipper would hold the other");
  return c;
}

}  // namespace

UgvMapConfig read_map_config(Profile& profile) {
  UgvMapConfig config;
  ChosenMapConfig& map = config.map;
  map.grid = read_grid(profile);
  read_segments(profile, map);
  const std::uint32_t voxels =
      whole(profile, "limits.voxels", {1 << 17, 4, 262'136, "voxels", "pool of the map; whole fours of it"});
  map.voxels = voxels / 4 * 4;
  const std::uint32_t blocks =
      whole(profile, "limits.blocks",
            {0, 0, 65'534, "blocks", "pool of the map's blocks of 4 x 4 x 4 voxels; 0: one for 4 voxels"});
  map.blocks = blocks > 0 ? blocks : std::min(map.voxels / 4, 65'534u);
  config.scan_buffers =
      whole(profile, "limits.scan_buffers", {4, 2, 64, "scans", "pooled buffers; a job takes up to half"});
  map.scan_points = whole(profile, "limits.scan_points",
                          {32'768, 1, 1 << 22, "points", "of one scan; a larger one is refused whole"});
  mapping::SweepConfig& sweep = config.sweep;
  const SensorMount mount = read_lidar_mount(profile);
  sweep.p_body_sensor_m = rt::to_vector(mount.place_m);
  sweep.q_body_sensor = rt::from_yaw_pitch_roll(mount.yaw_pitch_roll_rad[0], mount.yaw_pitch_roll_rad[1],
                                                mount.yaw_pitch_roll_rad[2]);
  sweep.time_offset_ns = milliseconds(
      profile.number("lidar.time_offset_ms", {0, -1000, 1000, "ms", "added to the lidar's stamps"}));
  sweep.max_ahead_ns = milliseconds(profile.number(
      "map.max_pose_age_ms",
      {100, 0, 1e4, "ms", "a return this long after the newest pose is placed where the motion went on to"}));
  sweep.min_range_m = map.grid.min_range_m;
  sweep.max_range_m = map.grid.max_range_m;
  sweep.robot = read_outline(profile);
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
