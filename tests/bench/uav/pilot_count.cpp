// SPDX-License-Identifier: BSD-3-Clause
// Instructions of a control step beside Lee's.
#include <cstdio>

#include "tests/bench/report/counted_child.hpp"
#include "tests/bench/uav/lee.hpp"
#include "tests/bench/uav/uav_parts.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::bench {
namespace {

constexpr int kCountedSteps = 3000;

}  // namespace

int run_counted_pilots() {
  // Both get the states of one flight of ours, with noise and the gust.
  const FlightSetup setup = usual_flight("neo11", Pilot::ours, 1.1, 5.0, true, 1);
  const FlightResult flown = fly(setup);
  if (flown.record.size() < kCountedSteps) return 1;
  planner::UavControl ours(setup.control);
  LeeController lee(setup.control.model, lee_gains("neo11"), 0.01);
  if (ours.start(flown.record[0].state) != Status::ok) return 1;
  std::vector<planner::FlatReference> wanted;
  for (const FlightSample& sample : flown.record) wanted.push_back(setup.path(sample.time_s));
  toolchain::start_counting();
  for (int pilot = 0; pilot < 2; ++pilot) {
    toolchain::mark_count();
    for (std::size_t k = 0; k < kCountedSteps; ++k) {
      rt::RotorCommand command;
      if (pilot == 0) {
        (void)ours.track(wanted[k]);
        (void)ours.update(flown.record[k].state, command);
      } else {
        lee.update(flown.record[k].state, wanted[k], command);
      }
    }
    toolchain::mark_count();
  }
  return 0;
}

int gate_pilots(const std::string& program) {
  const Marks counted = count_instructions({program, "--counted-pilots"});
  if (!counted.why_none.empty() || counted.instructions.size() != 4) {
    std::fprintf(stderr, "no count: %s\n", counted.why_none.c_str());
    return 77;
  }
  const auto ours = static_cast<double>(counted.instructions[1] - counted.instructions[0]);
  const auto theirs = static_cast<double>(counted.instructions[3] - counted.instructions[2]);
  std::printf("a control step: %.0f instructions, Lee's %.0f, ratio %.3f, goal <= 2\n", ours / kCountedSteps,
              theirs / kCountedSteps, ours / theirs);
  return ours <= 2.0 * theirs ? 0 : 1;
}

void measure_uav_count(const UavSettings& settings, Report& report) {
  const Marks counted = count_instructions({settings.program, "--counted-pilots"});
  if (!counted.why_none.empty() || counted.instructions.size() != 4) {
    report.skip("instructions of a step", counted.why_none.empty() ? "marks are missing" : counted.why_none);
    return;
  }
  const auto per_step = [&](std::size_t at) {
    return static_cast<double>(counted.instructions[at + 1] - counted.instructions[at]) / kCountedSteps;
  };
  const double ours = per_step(0);
  const double theirs = per_step(2);
  Figure figure{"instructions",
                "of a control step",
                "",
                kCountedSteps,
                spread(ours),
                "Lee",
                spread(theirs),
                spread(ours / theirs),
                {},
                {}};
  set_goal(figure, "ratio <= 2", ours <= 2.0 * theirs);
  report.add(figure);
}

}  // namespace sortie::bench
