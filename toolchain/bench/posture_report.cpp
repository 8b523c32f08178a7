// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> posture_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  const int cases = settings.value("cases", 0);
  return {settings_line(result, "seed " + std::to_string(settings.value("seed", 0)) +
                                    (cases > 0 ? ", " + std::to_string(cases) + " cases a row" : ""))};
}

}  // namespace

PeerFront posture_front() {
  PeerFront front;
  front.name = "posture";
  front.file = "bench-posture";
  front.about = "How a tracked vehicle would stand on cells of ground, beside the plant at rest";
  front.footer =
      "Thread CPU time on drawn courses. docs/posture.md tells what a posture is.\n"
      "Examples:\n"
      "  sortie bench posture --out out/posture\n"
      "  sortie bench posture --only plant --cases 2000\n"
      "  sortie bench posture --only sweep --json";
  front.options = {{"--cases", std::optional<std::uint64_t>{},
                    "Cases a row, if not as many as each part takes by itself", 1, 1000000},
                   {"--seed", std::uint64_t{1}, "Of courses, flippers and headings", 0, 1000000000},
                   choice("--only", "One part alone", {"plant", "sweep", "bounds"})};
  front.title = "Postures beside the plant at rest";
  front.intro =
      "Times are of the thread's processor: **take the ratios, not the microseconds**. What it is: "
      "[postures](../posture.md).";
  front.conditions = posture_conditions;
  front.headings = {{"plant", "Beside the plant at rest"},
                    {"sweep", "Error over run time: cells, samples, sweeps"},
                    {"bounds", "Bounds where cells are known between bounds only"}};
  front.pictures = drawn_pictures;
  return front;
}

}  // namespace sortie::toolchain
