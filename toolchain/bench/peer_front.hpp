// SPDX-License-Identifier: BSD-3-Clause
// How the benchmarks that have programs of their own look from here: what they are asked, and how what they
// found is shown.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "firmware_like/scene/json.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// A picture, the name of its file, and the group of figures that shows it; other groups come behind.
struct BenchPicture {
  std::string file;
  Plot plot;
  std::string group;
};

/// An option of the command, handed on to the program as it stands. A text that is empty, a flag that is not
/// set and a number that nobody gave are left out.
struct PeerOption {
  std::string name;  ///< --rounds
  std::variant<int, double, std::uint64_t, std::optional<std::uint64_t>, bool, std::string> value;
  std::string about;
  double low{};                        ///< of a number
  double high{};                       ///< both are always asked for
  std::vector<std::string> choices{};  ///< of a text; empty: any
  std::string type{};                  ///< what the help calls it, where that is not plain
  bool given{};                        ///< by whoever typed the command
};

/// A text that is one of these, or is not given.
inline PeerOption choice(const std::string& name, const std::string& about,
                         std::vector<std::string> choices) {
  return {name, std::string(), about, 0, 0, std::move(choices)};
}

/// One such benchmark. What is not said is as usual.
struct PeerFront {
  std::string name;  ///< of the command; the program is sortie-bench-NAME
  std::string file;  ///< of page and JSON, without .md and .json
  std::string about;
  std::string footer;
  std::vector<PeerOption> options;
  bool has_passes{true};
  bool all_timed{};                          ///< none of its figures is the same at every run
  bool on_one_line{};                        ///< its JSON file, which is large
  void (*adapt)(PeerFront&){};               ///< before it runs: what its options make of all this
  void (*finish)(firmware::Json&){};         ///< what is added to the result before it is shown
  bool (*is_good)(const firmware::Json&){};  ///< false: exit code 1

  std::string title;  ///< of the page
  std::string intro;  ///< of the page, behind "Written by `...`. "
  /// Lines below the machine's: settings, load.
  std::vector<std::string> (*conditions)(const firmware::Json&){};
  /// Groups, and what the page calls them; others by their own names.
  std::map<std::string, std::string> headings{};
  std::string (*overview)(const firmware::Json&){};  ///< before the first group, as Markdown
  std::vector<BenchPicture> (*pictures)(const firmware::Json&){};
  void (*print)(std::ostream&, const firmware::Json&, bool colour){};  ///< in place of print_bench()
  std::string (*page)(const firmware::Json&, const std::string&){};    ///< in place of bench_page()
};

PeerFront rt_front();            ///< the real-time ground beside cyclictest and boost
PeerFront plant_front();         ///< the tracked plant beside ODE
PeerFront mapping_front();       ///< the local map beside PCL
PeerFront registration_front();  ///< the registration of scans and clouds beside PCL's
PeerFront elevation_front();     ///< the elevation map beside elevation_mapping's filter
PeerFront recognition_front();   ///< sets of correspondences beside PCL's, CLIPPER's and ROBIN's
PeerFront ground_path_front();   ///< ways over the ground beside OMPL and exhaustive search
PeerFront uav_front();           ///< the multirotor beside Lee's controller and others
PeerFront stability_front();     ///< stiff and extreme cases beside the naive method
PeerFront campaign_front();      ///< hostile random sequences for every module
PeerFront ray_front();           ///< the ray scheduler beside the published planners; closed loops
PeerFront posture_front();       ///< how a tracked vehicle would stand, beside the plant at rest
PeerFront courses_front();       ///< drivers of the flippers over drawn courses
PeerFront flipper_front();       ///< the flippers' policy, and the plant led by it

/// Lateness of wake-ups: log count over microseconds, one curve a method, a line at the deadline.
std::vector<BenchPicture> rt_pictures(const firmware::Json& result);
/// Error over run time, and a side view of each drive over obstacles.
std::vector<BenchPicture> plant_pictures(const firmware::Json& result);
/// Error of segments over run time, a picture a stream.
std::vector<BenchPicture> mapping_pictures(const firmware::Json& result);
/// Worth over run time, and the chosen rays over the entropy of the map.
std::vector<BenchPicture> ray_pictures(const firmware::Json& result);
/// The course of the loss, scene by scene.
std::vector<BenchPicture> ray_loop_pictures(const firmware::Json& result);
/// The page of the closed loops: policies that aim the solid-state lidar.
std::string ray_loop_page(const firmware::Json& result, const std::string& command);
/// Whatever the program drew.
std::vector<BenchPicture> drawn_pictures(const firmware::Json& result);

/// All of them, in the help's order.
const std::vector<PeerFront>& peer_fronts();

/// "N rounds", or whatever `settings` says, with the load average before and after, and the passes.
std::string settings_line(const firmware::Json& result, const std::string& settings);
/// Machine, compiler, the front's own conditions, and the doctor's verdict: a line each.
std::vector<std::string> bench_conditions(const PeerFront& front, const firmware::Json& result);

/// The conditions and each group's figures and tables.
void print_bench(std::ostream& out, const PeerFront& front, const firmware::Json& result, bool colour);
/// The same as a Markdown page with the pictures in their groups, and `command` as how to get it again.
std::string bench_page(const PeerFront& front, const firmware::Json& result, const std::string& command);

/// True where there are figures and each has met its goal.
bool all_met(const firmware::Json& result);

}  // namespace sortie::toolchain
