// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> elevation_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return {settings_line(result, "seed " + std::to_string(settings.value("seed", 0)))};
}

}  // namespace

PeerFront elevation_front() {
  PeerFront front;
  front.name = "elevation";
  front.file = "bench-elevation";
  front.about = "The elevation map over a climb, beside elevation_mapping's filter";
  front.footer =
      "Thread CPU time on a simulated climb. docs/elevation.md tells what the map holds.\n"
      "Examples:\n"
      "  sortie bench elevation --out out/elevation\n"
      "  sortie bench elevation --only scan --way 5";
  front.options = {{"--seed", std::uint64_t{1}, "Of noise and drift", 0, 1000000000},
                   {"--way", 20.0, "Length of the climb, m", 1, 20},
                   choice("--only", "One part alone", {"scan", "sweep"})};
  front.title = "The elevation map";
  front.intro =
      "Times are of the thread's processor: **take the ratios, not the milliseconds**. The peer's filter is "
      "made again from its papers. What it is: [elevation](../elevation.md).";
  front.conditions = elevation_conditions;
  front.headings = {{"scan", "Time of a scan"}, {"sweep", "Error over run time: cells, rates, rays"}};
  return front;
}

}  // namespace sortie::toolchain
