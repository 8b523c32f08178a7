// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-registration: the registration of scans, planes and clouds beside PCL's, its error over run
// time, its basin, and what it says of places that are false. Prints one JSON object; `sortie bench
// registration` runs it and shows the tables.
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
  std::string counted;
  read_arguments(argc, argv,
                 {{"--cases", settings.cases, 1, 1e6},
                  {"--seed", settings.seed, 0, 1e9},
                  {"--only", only},
                  {"--data", settings.data},
                  {"--counted", counted}});
  if (!counted.empty()) return registration_counted(counted);
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
