// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "tests/bench/registration/matched_step.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/counted_child.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::bench {
namespace {

void count(Report& report, const char* what, const char* mode) {
  const Marks marks = count_instructions({toolchain::own_program_path(), "--counted", mode});
  if (!marks.why_none.empty()) return report.skip(std::string("instructions, ") + what, marks.why_none);
  Rounds steps;
  for (std::size_t i = 0; i + 1 < marks.instructions.size(); i += 2)
    steps.add(1e-6 * static_cast<double>(marks.instructions[i + 1] - marks.instructions[i]));
  Figure figure;
  figure.group = "counts";
  figure.what = std::string("instructions of a step, start ") + what;
  figure.unit = "million";
  figure.n = steps.size();
  figure.ours = spread(steps);
  const double worst = steps.high() / steps.median();
  set_goal(figure, "worst over median 1.5 at most", worst <= 1.5);
  report.add(figure);
}

}  // namespace

int registration_counted(const std::string& mode) {
  const bool lost = mode == "lost";
  const Known known = mode == "alone" ? Known::alone : Known::odometry;
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
      (void)matched_step(*maps[s], sets[s].scans[i].points, sets[s].starts[i], known);
      toolchain::mark_count();
    }
  }
  return 0;
}

void measure_registration_counts(const RegistrationSettings&, Report& report) {
  count(report, "0.05 m, 2 deg off", "tracked");
  count(report, "0.05 m, 2 deg off, no odometry: other poses are tried", "alone");
  count(report, "1 m, 60 deg off: all other starts are tried", "lost");
  report.note("counts",
              "At 2,048 returns, under callgrind: the same each time. A drive has both kinds of step: its "
              "worst one over its median one is the ratio of the two rows.");
}

}  // namespace sortie::bench
