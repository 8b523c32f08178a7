// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>

#include "tests/bench/registration/matched_step.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/registration/scan_sets.hpp"
#include "tests/bench/report/counted_child.hpp"
#include "tests/bench/report/figures.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::bench {
namespace {

void count(const char* what, const char* mode) {
  const Marks marks = count_instructions({toolchain::own_program_path(), "--counted", mode});
  if (!marks.why_none.empty()) {
    std::printf("\nskipped: %s\n", marks.why_none.c_str());
    return;
  }
  Rounds steps;
  for (std::size_t i = 0; i + 1 < marks.instructions.size(); i += 2)
    steps.add(1e-6 * static_cast<double>(marks.instructions[i + 1] - marks.instructions[i]));
  std::printf("| %s | %zu | %.2f | %.2f | %.2f |\n", what, steps.size(), steps.median(), steps.high(),
              steps.high() / steps.median());
  std::fflush(stdout);
}

}  // namespace

int registration_counted(bool lost) {
  mapping::RegistrationConfig config;
  config.returns = 2048;
  const StartError off{lost ? 1.0 : 0.05, (lost ? 60 : 2) * M_PI / 180, false};
  const std::vector<MapAndScans> sets = hall_set(lost ? 4 : 12, 5, off, 7);  // ahead: it is not counted
  std::vector<std::unique_ptr<OwnedRegistration>> maps;
  for (const MapAndScans& set : sets) maps.push_back(map_of(set, config));
  toolchain::start_counting();
  for (std::size_t s = 0; s < sets.size(); ++s) {
    for (std::size_t i = 0; i < sets[s].scans.size(); ++i) {
      toolchain::mark_count();
      (void)matched_step(*maps[s], sets[s].scans[i].points, sets[s].starts[i], 0.0);
      toolchain::mark_count();
    }
  }
  return 0;
}

void registration_counts(const RegistrationSettings&) {
  std::puts(
      "\nInstructions of the step at 2,048 returns, under callgrind.\n\n"
      "| start | n | median, M | worst, M | worst over median |\n|---|---:|---:|---:|---:|");
  count("0.05 m, 2 deg off", "tracked");
  count("1 m, 60 deg off", "lost");
}

}  // namespace sortie::bench
