// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> flipper_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  const int cases = settings.value("cases", 0);
  return {settings_line(result, "seed " + std::to_string(settings.value("seed", 0)) +
                                    (cases > 0 ? ", " + std::to_string(cases) + " cases a row" : ""))};
}

}  // namespace

PeerFront flipper_front() {
  PeerFront front;
  front.name = "flippers";
  front.file = "bench-flippers";
  front.about = "Which flipper angles a policy chooses on drawn ground, and the plant led by it";
  front.footer =
      "Thread CPU time on drawn courses. docs/flippers.md tells what the policy is.\n"
      "Examples:\n"
      "  sortie bench flippers --out out/flippers\n"
      "  sortie bench flippers --only drives --cases 20\n"
      "  sortie bench flippers --only masked --json";
  front.options = {{"--cases", std::optional<std::uint64_t>{},
                    "Cases a row, if not as many as each part takes by itself", 1, 1000000},
                   {"--seed", std::uint64_t{100001}, "Of courses, places and masks", 0, 1000000000},
                   choice("--only", "One part alone", {"search", "masked", "drives"})};
  front.title = "The flippers' policy";
  front.intro =
      "Times are of the thread's processor: **take the ratios, not the microseconds**. What it is: "
      "[flippers](../flippers.md).";
  front.conditions = flipper_conditions;
  front.headings = {{"search", "Cost and time over the choices that are tried"},
                    {"masked", "Cells masked"},
                    {"drives", "The plant over drawn courses"}};
  front.pictures = drawn_pictures;
  return front;
}

}  // namespace sortie::toolchain
