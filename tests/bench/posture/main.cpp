// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-posture: postures on ground of cells beside the plant at rest, their error over run time, and
// how wide their bounds are. Prints one JSON object; `sortie bench posture` runs it and shows the tables.
#include <stdexcept>

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
  for (int i = 1; i < argc; i += 2) {
    const std::string option = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : nullptr;
    if (option == "--cases")
      settings.cases = static_cast<int>(number("--cases", value, 1, 1e6));
    else if (option == "--seed")
      settings.seed = static_cast<std::uint64_t>(number("--seed", value, 0, 1e9));
    else if (option == "--only" && value != nullptr)
      only = value;
    else
      throw std::invalid_argument("unknown option " + option);
  }
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
