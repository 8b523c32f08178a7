// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-uav: flies simulated multirotors with the state controller and its peers and prints one JSON
// object.
#include <stdexcept>

#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/parts.hpp"
#include "tests/bench/uav/uav_parts.hpp"
#include "toolchain/bench/child_process.hpp"

namespace sortie::bench {
namespace {

constexpr BenchPart<UavSettings> kUavParts[] = {
    {"peers", measure_uav_peers},       {"stress", measure_uav_stress}, {"estimated", measure_uav_estimated},
    {"orders", measure_uav_orders},     {"rates", measure_uav_sweep},   {"plant", measure_uav_steps},
    {"pictures", measure_uav_pictures}, {"paths", measure_uav_paths},   {"count", measure_uav_count}};

int run_uav(int argc, char** argv) {
  UavSettings settings;
  std::string only;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--counted-pilots") return run_counted_pilots();
    if (option == "--gate") return gate_pilots(toolchain::own_program_path());
    const char* value = ++i < argc ? argv[i] : nullptr;
    if (option == "--seeds")
      settings.seeds = static_cast<std::uint64_t>(number("--seeds", value, 1, 1000));
    else if (option == "--fleet")
      settings.fleet = static_cast<std::uint64_t>(number("--fleet", value, 1, 1e5));
    else if (option == "--only" && value != nullptr)
      only = value;
    else
      throw std::invalid_argument("unknown option " + option);
  }
  settings.program = toolchain::own_program_path();
  print_parts<UavSettings>(kUavParts, settings, only, {{"seeds", settings.seeds}, {"fleet", settings.fleet}});
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-uav",
                                     [argc, argv] { return sortie::bench::run_uav(argc, argv); });
}
