// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> ground_path_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return {settings_line(result, std::to_string(settings.value("maps", 0)) + " halls from seed " +
                                    std::to_string(settings.value("seed", 0)) + ", OMPL " +
                                    firmware::format_fixed(settings.value("seconds", 0.0), 1) + " s each")};
}

}  // namespace

PeerFront ground_path_front() {
  PeerFront front;
  front.name = "ground-path";
  front.file = "bench-ground-path";
  front.about = "Ways over the ground beside OMPL's RRT* and BIT* and exhaustive search: cost over run time";
  front.footer =
      "Costs are exact and repeat; run times depend on the machine. docs/ground-path.md tells what plans.\n"
      "Examples:\n"
      "  sortie bench ground-path --out out/ground-path\n"
      "  sortie bench ground-path --only budget --maps 100\n"
      "  sortie bench ground-path --only peers --seconds 20 --json";
  front.options = {{"--maps", std::uint64_t{10}, "Halls that are drawn", 1, 1000},
                   {"--seed", std::uint64_t{1}, "Of the first hall", 0, 1000000000},
                   {"--seconds", 5.0, "Processor time of each of OMPL's planners, a hall", 0.1, 1000},
                   choice("--only", "One part alone", {"peers", "budget", "resolution", "unknown"})};
  front.title = "Ways over the ground";
  front.intro =
      "Costs are exact and repeat; run times are CPU time of one core and depend on the machine: **their "
      "ratios travel**. What plans: [ground path](../ground-path.md).";
  front.conditions = ground_path_conditions;
  front.headings = {{"peers", "Beside OMPL and exhaustive search"},
                    {"budget", "Cost over budget"},
                    {"resolution", "Cost and run time over the size of a cell"},
                    {"unknown", "Ground that was not seen"}};
  front.pictures = drawn_pictures;
  return front;
}

}  // namespace sortie::toolchain
