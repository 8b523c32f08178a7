// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-posture: postures on ground of cells beside the plant at rest, their error over run time, and
// how wide their bounds are. Prints one JSON object; `sortie bench posture` runs it and shows the tables.
#include "tests/bench/posture/posture_parts.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/parts.hpp"

namespace sortie::bench {
namespace {

constexpr BenchPart<PostureSettings> kPostureParts[] = {
    {"plant", measure_posture_plant}, {"sweep", measure_posture_sweep}, {"bounds", measure_posture_bounds}};

int run(int argc, char** argv) {
  PostureSettings settings;
  std::string only;
  read_arguments(argc, argv,
                 {{"--cases", settings.cases, 1, 1e6}, {"--seed", settings.seed, 0, 1e9}, {"--only", only}});
  print_parts<PostureSettings>(kPostureParts, settings, only,
                               {{"cases", settings.cases}, {"seed", settings.seed}});
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-posture",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
