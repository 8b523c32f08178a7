// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-registration: registration of scans beside PCL's, its error over run time, its basin, and what
// it says of places that are false; tables in Markdown. --only PART (peers, sweep, basin, places, counts,
// corridor),
// --cases N, --seed N, --out DIR for the plots, --data DIR, --each yes for a line a case that went wrong.
#include <cstdio>
#include <stdexcept>

#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/arguments.hpp"

namespace sortie::bench {
namespace {

struct RegistrationPart {
  const char* name;
  void (*measure)(const RegistrationSettings&);
};
constexpr RegistrationPart kRegistrationParts[] = {
    {"peers", registration_beside_peers}, {"sweep", registration_sweep},
    {"counts", registration_counts},      {"basin", registration_basin},
    {"places", registration_places},      {"corridor", registration_corridor}};

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
    else if (option == "--out" && value != nullptr)
      settings.out = value;
    else if (option == "--data" && value != nullptr)
      settings.data = value;
    else if (option == "--each" && value != nullptr)
      settings.each = std::string(value) == "yes";
    else if (option == "--counted" && value != nullptr)
      return registration_counted(std::string(value) == "lost");
    else
      throw std::invalid_argument("unknown option " + option);
  }
  std::printf("load average %s, seed %llu\n", load_average().c_str(),
              static_cast<unsigned long long>(settings.seed));
  bool found = false;
  for (const RegistrationPart& part : kRegistrationParts) {
    if (!only.empty() && only != part.name) continue;
    found = true;
    part.measure(settings);
  }
  if (!found) throw std::invalid_argument("--only takes peers, sweep, counts, basin, places or corridor");
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-registration",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
