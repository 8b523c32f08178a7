// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> plant_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return {settings_line(result, std::to_string(settings.value("rounds", 0)) + " rounds")};
}

std::string scene_list(const firmware::Json& result) {
  std::string text = "\n| scene | drive | friction |\n|---|---|---:|\n";
  for (const firmware::Json& scene : result.value("scenes", firmware::Json::array())) {
    text += "| " + scene.value("name", "") + " | " + scene.value("about", "") + " | " +
            firmware::format_short(scene.value("friction", 0.0)) + " |\n";
  }
  return text;
}

}  // namespace

PeerFront plant_front() {
  PeerFront front;
  front.name = "plant";
  front.file = "bench-plant";
  front.about = "The tracked plant beside ODE: run time, errors, turning, step size, penetration";
  front.footer =
      "Ours and ODE's slices alternate, so ratios hold on a busy machine, too. docs/plant.md tells what the "
      "model is.\n"
      "Examples:\n"
      "  sortie bench plant --out out/plant\n"
      "  sortie bench plant --only speed --scene pallet --rounds 11\n"
      "  sortie bench plant --only belt --json";
  front.options = {
      {"--rounds", 5, "Rounds of what is timed; each holds slices of all", 1, 10000},
      choice("--only", "One part alone", {"speed", "count", "metrics", "belt", "steps", "depth", "pictures"}),
      choice("--scene", "One scene alone",
             {"straight", "rotate", "circular", "ramp", "stairs-down", "stand", "pallet", "back-and-forth",
              "stairs-up"})};
  front.title = "The tracked plant beside ODE";
  front.intro =
      "Ours and the peer's figures come from alternating slices of the same run: **the ratios travel, "
      "absolute times do not**. Figures are medians of the rounds, in brackets the range over the rounds; "
      "ratio is ours over theirs. The model: [plant](../plant.md).";
  front.conditions = plant_conditions;
  front.headings = {{"speed", "Run time of a step"},
                    {"instructions", "Instructions of a step"},
                    {"metrics", "Where drives end: contact surface motion"},
                    {"belt", "How belts turn"},
                    {"step size", "Error against step size against run time"},
                    {"penetration", "Penetration and residual"}};
  front.overview = scene_list;
  front.pictures = plant_pictures;
  return front;
}

}  // namespace sortie::toolchain
