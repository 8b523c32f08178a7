// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> recognition_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  const int cases = settings.value("cases", 0);
  return {settings_line(result, "seed " + std::to_string(settings.value("seed", 0)) +
                                    (cases > 0 ? ", " + std::to_string(cases) + " cases a row" : ""))};
}

}  // namespace

PeerFront recognition_front() {
  PeerFront front;
  front.name = "recognition";
  front.file = "bench-recognition";
  front.about =
      "Segments that look alike, beside seven features; sets that agree, beside PCL, CLIPPER and ROBIN";
  front.footer =
      "Thread CPU time on drawn correspondences, graphs and halls. docs/recognition.md tells what is\n"
      "searched.\n"
      "Examples:\n"
      "  sortie bench recognition --out out/recognition\n"
      "  sortie bench recognition --only outliers --cases 200\n"
      "  sortie bench recognition --only graphs --json";
  front.options = {
      {"--cases", std::optional<std::uint64_t>{}, "Cases a row, if not as many as each part takes by itself",
       1, 1000000},
      {"--seed", std::uint64_t{1}, "Of streets, correspondences, graphs, halls and worlds", 0, 1000000000},
      choice("--only", "One part alone",
             {"streets", "outliers", "graphs", "descriptors", "deceive", "revisits", "evidence", "rest",
              "places", "sweep", "visits", "loops", "images"}),
      {"--data", std::string(), "Folder of the recorded data", 0, 0, {}, "DIR"}};
  front.title = "Recognition of places";
  front.intro =
      "Times are of the thread's processor: **take the ratios, not the milliseconds**. Tables and pictures "
      "are of the first pass. CLIPPER's dense cluster, ROBIN's densest core, SOLiD and binary features on "
      "density images (MapClosures) are made again from their papers; PCL is the installed one. What it is: "
      "[recognition](../recognition.md).";
  front.conditions = recognition_conditions;
  front.headings = {{"streets", "Beside PCL's grouping: a drive through streets"},
                    {"outliers", "Beside a dense cluster and the densest core: most are wrong"},
                    {"graphs", "Any graph: what a budget finds"},
                    {"descriptors", "Segments of two visits: how well they are told apart"},
                    {"deceive", "Worlds that are built to deceive"},
                    {"revisits", "Halls that are visited twice: what is recognised"},
                    {"evidence", "What a scan has to say before it is believed"},
                    {"rest", "How long a segment must be at rest before it speaks"},
                    {"places", "Places of two visits: beside SOLiD and density images"},
                    {"sweep", "Error over run time: one knob at a time"},
                    {"visits", "A recorded lidar, cut into two visits"},
                    {"loops", "Long recorded drives through made-up towns"},
                    {"images", "Corridors and empty halls: height images beside segments"}};
  front.pictures = drawn_pictures;
  return front;
}

}  // namespace sortie::toolchain
