// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-flippers: the flippers' policy on drawn ground: cost and time over what is tried, masked
// cells, and the plant in the loop. Prints one JSON object; `sortie bench flippers` runs it and shows the
// tables.
#include "tests/bench/flippers/flipper_parts.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/parts.hpp"

namespace sortie::bench {
namespace {

constexpr BenchPart<FlipperSettings> kFlipperParts[] = {{"search", measure_flipper_search},
                                                        {"masked", measure_flipper_masks},
                                                        {"drives", measure_flipper_drives}};

int run(int argc, char** argv) {
  FlipperSettings settings;
  std::string only;
  read_arguments(argc, argv,
                 {{"--cases", settings.cases, 1, 1e6}, {"--seed", settings.seed, 0, 1e9}, {"--only", only}});
  print_parts<FlipperSettings>(kFlipperParts, settings, only,
                               {{"cases", settings.cases}, {"seed", settings.seed}});
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-flippers",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
