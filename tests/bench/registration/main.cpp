// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-registration: the registration of scans, planes and clouds beside PCL's, its error over run
// time, its basin, and what it says of places that are false. Prints one JSON object; `sortie bench
// registration` runs it and shows the tables.
#include <stdexcept>

#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/parts.hpp"

namespace sortie::bench {
namespace {

constexpr BenchPart<RegistrationSettings> kRegistrationParts[] = {
    {"peers", measure_registration_peers},       {"sweep", measure_registration_sweep},
    {"fields", measure_registration_fields},     {"counts", measure_registration_counts},
    {"basin", measure_registration_basin},       {"places", measure_registration_places},
    {"walk", measure_registration_walk},         {"lost", measure_registration_lost},
    {"corridor", measure_registration_corridor}, {"planes", measure_registration_planes},
    {"clouds", measure_registration_clouds}};

int run(int argc, char** argv) {
  RegistrationSettings settings;
  settings.data = SORTIE_DATA_DIR;
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
    else if (option == "--data" && value != nullptr)
      settings.data = value;
    else if (option == "--counted" && value != nullptr)
      return registration_counted(value);
    else
      throw std::invalid_argument("unknown option " + option);
  }
  print_parts<RegistrationSettings>(kRegistrationParts, settings, only,
                                    {{"cases", settings.cases}, {"seed", settings.seed}});
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-registration",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
