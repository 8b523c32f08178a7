// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> courses_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  const std::string family = settings.value("family", "");
  return {settings_line(result, "seed " + std::to_string(settings.value("seed", 0)) + ", " +
                                    std::to_string(settings.value("cases", 0)) + " courses a family" +
                                    (family.empty() ? "" : ", " + family + " alone"))};
}

}  // namespace

PeerFront courses_front() {
  PeerFront front;
  front.name = "courses";
  front.file = "bench-courses";
  front.about = "Drivers of the tracked vehicle's flippers over courses drawn by seed";
  front.footer =
      "Drives the simulated vehicle. docs/traversal.md tells what a course is, and who judges.\n"
      "Examples:\n"
      "  sortie bench courses --out out/courses\n"
      "  sortie bench courses --only drivers --cases 40\n"
      "  sortie bench courses --family stairs-up --cases 20 --json";
  front.options = {{"--cases", std::uint64_t{2}, "Courses a family, of tuning and of judging", 1, 100000},
                   {"--seed", std::uint64_t{1}, "Of the first course; case n has seed N + n", 0, 1000000000},
                   choice("--family", "One family alone",
                          {"step-up", "step-down", "uplift", "one-side", "posts", "waves", "rails",
                           "stairs-up", "stairs-down", "pallets", "ramp", "rubble", "gap"}),
                   choice("--only", "One part alone", {"tuning", "drivers"})};
  front.title = "Courses for the tracked vehicle";
  front.intro = "Deterministic but for its run time. What it is: [traversal](../traversal.md).";
  front.conditions = courses_conditions;
  front.headings = {{"tuning", "Fixed postures and other drivers over courses for tuning"},
                    {"drivers", "Drivers over courses for judging"}};
  return front;
}

}  // namespace sortie::toolchain
