// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> registration_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  const int cases = settings.value("cases", 0);
  return {settings_line(result, "seed " + std::to_string(settings.value("seed", 0)) +
                                    (cases > 0 ? ", " + std::to_string(cases) + " cases a row" : ""))};
}

}  // namespace

PeerFront registration_front() {
  PeerFront front;
  front.name = "registration";
  front.file = "bench-registration";
  front.about = "Scans, planes and clouds registered, beside PCL: run time, error, starts, false places";
  front.footer =
      "Thread CPU time in simulated halls and on recorded scans. docs/registration.md tells what is "
      "registered.\n"
      "Examples:\n"
      "  sortie bench registration --out out/registration\n"
      "  sortie bench registration --only fields\n"
      "  sortie bench registration --only basin --cases 200 --json";
  front.options = {{"--cases", std::optional<std::uint64_t>{},
                    "Cases a row, if not as many as each part takes by itself", 1, 1000000},
                   {"--seed", std::uint64_t{1}, "Of halls, buildings and starts", 0, 1000000000},
                   choice("--only", "One part alone",
                          {"peers", "sweep", "fields", "counts", "basin", "places", "walk", "lost",
                           "corridor", "planes", "clouds"}),
                   {"--data", std::string(), "Folder of the recorded data", 0, 0, {}, "DIR"}};
  front.has_passes = false;
  front.title = "Registration beside PCL, and its error over run time";
  front.intro =
      "Times are of the thread's processor: **take the ratios, not the milliseconds**. *front*: no other "
      "cell "
      "is as cheap (within 5 %) and better (by 0.1 %); *defaults*: what a profile has by itself. What it is: "
      "[the robot's place on its own map](../registration.md); what was measured by tests: "
      "[registration](registration.md).";
  front.conditions = registration_conditions;
  front.headings = {
      {"peers", "Beside PCL"},
      {"sweep, halls", "Error over run time: returns, steps and cell, halls"},
      {"sweep, recorded drive", "Error over run time: returns, steps and cell, recorded drive"},
      {"fields, halls", "Error over run time: field of view and rows, halls"},
      {"fields, a sweep of the TRADR robot", "Error over run time: field of view and rows, recorded sweep"},
      {"counts", "Instructions"},
      {"basin", "Starts far off"},
      {"places", "Scans of other halls"},
      {"walk", "A recorded lidar alone"},
      {"lost", "Lost on a kept map"},
      {"corridor", "A corridor without ends"},
      {"planes", "Planes"},
      {"clouds", "Clouds from the air on the ground's"}};
  front.pictures = drawn_pictures;
  return front;
}

}  // namespace sortie::toolchain
