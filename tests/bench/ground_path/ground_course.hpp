// SPDX-License-Identifier: BSD-3-Clause
// How the cost of a way falls with run time: ours.
#pragma once

#include <vector>

#include "tests/bench/ground_path/ground_halls.hpp"

namespace sortie::bench {

/// A cheaper way, and when it was there. Seconds of driving at the prices; ms of the thread's processor.
struct CourseStep {
  double ms{};
  double cost_s{};
  std::uint64_t units{};
};

/// A plan from the first unit to the proof.
struct GroundCourse {
  std::vector<CourseStep> steps;
  double end_ms{};
  double worst_slice_ms{};
  std::uint64_t end_units{};
  std::uint32_t expanded{};
  planner::GroundPathState state{};
};

/// CPU time of the calling thread, ms.
double ground_cpu_ms();

/// Plans in slices of 500 units on a map that was laid out just now, so that nothing is judged yet.
GroundCourse run_course(planner::test::OwnedGround& ground, const planner::GroundPose& start,
                        const planner::GroundPose& goal);

/// ms until the cost was at most `cost_s`; negative: never.
double reached_ms(const std::vector<CourseStep>& steps, double cost_s);
/// Seconds of a planner's cost.
double cost_seconds(std::uint32_t cost);

}  // namespace sortie::bench
