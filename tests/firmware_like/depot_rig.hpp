// SPDX-License-Identifier: BSD-3-Clause
// The depot from the air: a cloud that one vehicle keeps, the map of its boxes, and another vehicle that is
// to find its place on both.
#pragma once

#include <fstream>

#include "firmware_like/parts/stored_cells.hpp"
#include "firmware_like/parts/uav_config.hpp"
#include "firmware_like/parts/world_boxes.hpp"
#include "mapping/registration/cloud_file.hpp"
#include "mapping/registration/cloud_match.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {

inline firmware::LiveRunOptions depot_options(double seconds, std::vector<std::string> overrides) {
  firmware::LiveRunOptions options;
  options.scene = "uav_depot";
  options.overrides = std::move(overrides);
  options.seconds = seconds;
  options.virtual_time = true;
  options.lcm_url = "none";
  return options;
}

inline firmware::LiveRunOutcome run_depot(const firmware::LiveRunOptions& options) {
  watch_heap();
  return firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
}

/// Writes the cloud that a run ended with.
inline std::vector<std::uint8_t> write_cloud_of(const firmware::LiveRunOutcome& run,
                                                const std::string& path) {
  const mapping::SensedCloud* cloud = run.runtime->vehicle().cloud();
  REQUIRE(cloud != nullptr);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::cloud_bytes(*cloud->layer)));
  REQUIRE(mapping::write_cloud(*cloud->layer, cloud->sensor, bytes) == Status::ok);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

/// A vehicle with a lidar in place of the camera keeps the cloud that it makes on its way.
inline std::vector<std::uint8_t> keep_cloud(double seconds, const std::string& path) {
  return write_cloud_of(
      run_depot(depot_options(
          seconds, {"hil.camera_hz=0", "hil.lidar_hz=5", "hil.lidar_rows=32", "cloud.sensor=\"laser\"",
                    "cloud.min_points=8", "cloud.max_range_m=20", "lidar.pitch_deg=0"})),
      path);
}

/// What a robot that saw everything would say of the depot's air: blocked wherever a box is.
inline std::string depot_cells() {
  firmware::Profile profile = firmware::load_scene("uav_depot", {});
  const planner::FlightMapConfig map = firmware::read_flight_voxels(profile).map;
  const std::vector<firmware::WorldBox> boxes = firmware::read_world_boxes(profile);
  std::vector<firmware::CellState> cells;
  for (int z = 0; z < map.nz; ++z) {
    for (int y = 0; y < map.ny; ++y) {
      for (int x = 0; x < map.nx; ++x) {
        const double low[3] = {map.origin_m.x + x * map.voxel_m, map.origin_m.y + y * map.voxel_m,
                               map.origin_m.z + z * map.voxel_m};
        bool blocked = false;
        for (const firmware::WorldBox& box : boxes) {
          bool meets = true;
          for (int i = 0; i < 3; ++i)
            meets = meets && low[i] < box.highest_m[i] && low[i] + map.voxel_m > box.lowest_m[i];
          blocked = blocked || meets;
        }
        cells.push_back(blocked ? firmware::CellState::blocked : firmware::CellState::free);
      }
    }
  }
  return "flight_map.cells=\"" + firmware::pack_cells(cells) + "\"";
}

/// The vehicle's own frame lies elsewhere.
inline std::vector<std::string> displaced(std::vector<std::string> more) {
  for (const char* key : {"flight_map.source=\"stored\"", "hil.frame_x_m=1.3", "hil.frame_y_m=-0.7",
                          "hil.frame_z_m=0.2", "hil.frame_yaw_deg=4"})
    more.emplace_back(key);
  more.push_back(depot_cells());
  return more;
}

/// The cloud of a ground robot that drives through the depot.
inline void keep_ground_cloud(const std::string& path) {
  firmware::LiveRunOptions options = depot_options(165, {"tasks.map.enabled=true"});
  options.scene = "ugv_depot";
  static_cast<void>(write_cloud_of(run_depot(options), path));
}

/// A vehicle that starts in a frame of its own looks for its place on a cloud, and flies by its map to its
/// goals and home. False: it was not placed.
inline bool flies_by_cloud(const std::string& map, std::uint32_t seed) {
  INFO("seed " << seed);
  firmware::LiveRunOptions options = depot_options(300, displaced({"hil.seed=" + std::to_string(seed)}));
  options.maps.map = map;
  const firmware::LiveRunOutcome run = run_depot(options);
  const auto& counters = run.results.counters;
  CHECK(counters.at("bench_collisions") == 0);
  if (counters.at("join_placed") == 0) return false;
  CHECK(counters.at("goals_reached") == 2);
  CHECK(counters.at("bench_landed") == 1);
  // Home, in the depot's frame, lies here in its own.
  const rt::Quaternion back = rt::from_yaw_pitch_roll(-4.0 * rt::kDegInRad.kept, 0, 0);
  const rt::Vector3 home = rt::rotate(back, rt::Vector3{-1.3, 0.7, 0});
  CHECK(std::hypot(run.truth.back().p[0] - home.x, run.truth.back().p[1] - home.y) < 0.3);
  return true;
}

}  // namespace sortie::testing
