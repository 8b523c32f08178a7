// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> uav_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return {settings_line(result, std::to_string(settings.value("seeds", 0)) + " seeds, " +
                                    std::to_string(settings.value("fleet", 0)) + " drawn vehicles")};
}

}  // namespace

PeerFront uav_front() {
  PeerFront front;
  front.name = "uav";
  front.file = "bench-uav";
  front.about = "The multirotor beside its peers: flights, stress, error against run time, ways";
  front.footer =
      "Flights are simulated and repeat exactly; only run times depend on the machine. docs/uav.md tells "
      "what flies.\n"
      "Examples:\n"
      "  sortie bench uav --out out/uav\n"
      "  sortie bench uav --only stress --fleet 400\n"
      "  sortie bench uav --only rates --json";
  front.options = {
      {"--seeds", std::uint64_t{3}, "Seeds of noise, a flight each", 1, 1000},
      {"--fleet", std::uint64_t{40}, "Vehicles that are drawn", 1, 100000},
      choice("--only", "One part alone",
             {"peers", "stress", "estimated", "orders", "rates", "plant", "pictures", "paths", "count"})};
  front.title = "The multirotor beside its peers";
  front.intro =
      "Flights are simulated and repeat exactly; run times are CPU time of one core and depend on the "
      "machine: **their ratios travel**. What flies: [flight](../uav.md), [its way](../uav-path.md).";
  front.conditions = uav_conditions;
  front.headings = {{"peers", "The same flights as Lee's controller"},
                    {"stress", "One stress at a time"},
                    {"moves", "Goals"},
                    {"lost rotor", "One rotor of six lost in hover, undeclared"},
                    {"fleet", "Vehicles that nobody tuned for"},
                    {"estimated", "On estimates"},
                    {"orders", "Error against run time: estimators"},
                    {"rates", "Error against run time: control rates, with the observer and without"},
                    {"plant", "Error against run time: the plant's integrator and step"},
                    {"gust", "A gust"},
                    {"way", "A planned way, flown"},
                    {"paths", "Ways through 1.6 million voxels"},
                    {"instructions", "Instructions of a control step"}};
  front.pictures = drawn_pictures;
  return front;
}

}  // namespace sortie::toolchain
