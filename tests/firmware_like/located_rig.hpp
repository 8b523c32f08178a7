// SPDX-License-Identifier: BSD-3-Clause
// Runs of a robot in a hall that is located, and one of them that was recorded.
#pragma once

#include <string>
#include <vector>

#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {

/// A run on a virtual clock, judged.
inline firmware::LiveRunOutcome run_virtually(const std::string& scene, std::vector<std::string> overrides,
                                              double seconds, const std::string& log,
                                              const std::string& map) {
  watch_heap();
  firmware::LiveRunOptions options;
  options.scene = scene;
  options.overrides = std::move(overrides);
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = log;
  options.maps.map = map;
  options.record_fields = true;
  options.lcm_url = "none";
  firmware::LiveRunOutcome run =
      firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
  static_cast<void>(toolchain::judge(run));
  return run;
}

inline firmware::LiveRunOutcome run_located(double seconds, const std::string& log,
                                            std::vector<std::string> more, const std::string& map = "") {
  more.insert(more.end(), {"hil.lidar_rows=16", "hil.lidar_columns=180", "limits.voxels=65536",
                           "tasks.map.budget_us=20000"});
  return run_virtually("ugv_hall", std::move(more), seconds, log, map);
}

inline std::uint64_t counted(const firmware::LiveRunOutcome& run, const std::string& name) {
  return run.results.counters.at(name);
}

inline double error_of(const firmware::Results& results, const std::string& name) {
  return results.errors.at(name);
}

/// A drive of 8 s with map, recorded once a program.
struct LocatedHall {
  TempFolder folder;
  std::string log = folder.file("located.lcm");
  firmware::LiveRunOutcome run = run_located(8, log, {"tasks.locate.enabled=true"});
};
inline const LocatedHall& located_hall() {
  static const LocatedHall recorded;
  return recorded;
}

}  // namespace sortie::testing
