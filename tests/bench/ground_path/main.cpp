// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-ground-path: plans ways over the ground of drawn halls beside OMPL and exhaustive search and
// prints one JSON object.
#include "tests/bench/ground_path/ground_parts.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/parts.hpp"

namespace sortie::bench {
namespace {

constexpr BenchPart<GroundSettings> kGroundParts[] = {{"peers", measure_ground_peers},
                                                      {"budget", measure_ground_budget},
                                                      {"resolution", measure_ground_resolution},
                                                      {"unknown", measure_ground_unknown}};

int run_ground(int argc, char** argv) {
  GroundSettings settings;
  std::string only;
  read_arguments(argc, argv,
                 {{"--maps", settings.maps, 1, 1000},
                  {"--seed", settings.seed, 0, 1e9},
                  {"--seconds", settings.seconds, 0.1, 1000},
                  {"--only", only}});
  print_parts<GroundSettings>(
      kGroundParts, settings, only,
      {{"maps", settings.maps}, {"seed", settings.seed}, {"seconds", settings.seconds}});
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-ground-path",
                                     [argc, argv] { return sortie::bench::run_ground(argc, argv); });
}
