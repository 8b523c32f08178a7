// SPDX-License-Identifier: BSD-3-Clause
// A hall that one run has seen, and runs of a robot that is lost there.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "mapping/recognition/target_file.hpp"
#include "tests/firmware_like/kept_map_rig.hpp"

namespace sortie::testing {

inline const std::vector<std::string> kRecognising = {
    "map.segments=smoothness",  "tasks.recognise.enabled=true", "tasks.locate.enabled=true",
    "hil.lidar_rows=16",        "hil.lidar_columns=180",        "limits.voxels=65536",
    "tasks.map.budget_us=20000"};

inline firmware::LiveRunOutcome run_recognising(double seconds, const std::string& log,
                                                const firmware::KeptMapPaths& maps,
                                                const std::vector<std::string>& more) {
  watch_heap();
  firmware::LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = kRecognising;
  options.overrides.insert(options.overrides.end(), more.begin(), more.end());
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = log;
  options.maps = maps;
  options.lcm_url = "none";
  firmware::LiveRunOutcome run =
      firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
  static_cast<void>(toolchain::judge(run));
  return run;
}

inline std::vector<std::uint8_t> target_bytes(const firmware::Runtime& runtime) {
  const mapping::TargetStore* targets = runtime.vehicle().targets();
  REQUIRE(targets != nullptr);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::target_file_bytes(*targets)));
  REQUIRE(mapping::write_targets(*targets, bytes) == Status::ok);
  return bytes;
}

inline void write(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// A drive of a minute through the hall, what it saw, and the way round for another one; made once.
struct SeenHall {
  TempFolder folder;
  std::string log = folder.file("first.lcm");
  firmware::KeptMapPaths kept{folder.file("hall.surfels"), folder.file("hall.targets"), ""};
  firmware::LiveRunOutcome run = run_recognising(60, log, {}, {});
  std::vector<std::uint8_t> bytes = target_bytes(*run.runtime);
  SeenHall() {
    write(kept.targets, bytes);
    write(kept.map, map_bytes(*run.runtime));
  }
};
inline const SeenHall& seen_hall() {
  static const SeenHall seen;
  return seen;
}

/// A robot that is lost there, from the other side.
inline firmware::LiveRunOutcome run_lost(double seconds, const std::string& log,
                                         std::vector<std::string> more,
                                         const firmware::KeptMapPaths& kept = seen_hall().kept) {
  more.insert(
      more.end(),
      {"locate.window_cells=256",
       "mission.waypoints=[[0.0,-4.0],[9.3,-4.0],[14.0,-4.0],[14.0,4.0],[9.3,4.0],[9.3,0.0],[0.0,0.0]]"});
  return run_recognising(seconds, log, kept, more);
}

/// A robot that is lost there, too, and begins at the other end, turned about: its odometry's world is the
/// hall's turned by 180 degrees, its origin 14 m along x.
inline firmware::LiveRunOutcome run_entering(double seconds, const std::string& log,
                                             std::vector<std::string> more) {
  more.insert(more.end(),
              {"locate.window_cells=256", "hil.start_x_m=14", "hil.start_yaw_deg=180",
               "mission.waypoints=[[0.0,-4.0],[4.7,-4.0],[4.7,0.0],[14.0,0.0],[14.0,4.0],[4.7,4.0],[0.0,4.0],"
               "[0.0,0.0]]"});
  return run_recognising(seconds, log, seen_hall().kept, more);
}

}  // namespace sortie::testing
