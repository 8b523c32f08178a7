// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/ground_path/ground_course.hpp"

#include <algorithm>

#include "rt/posix/clock.hpp"

namespace sortie::bench {

double ground_cpu_ms() { return 1e-6 * static_cast<double>(rt::posix::thread_cpu_now()); }

double cost_seconds(std::uint32_t cost) { return 1e-3 * cost / planner::kCostPerMs; }

GroundCourse run_course(planner::test::OwnedGround& ground, const planner::GroundPose& start,
                        const planner::GroundPose& goal) {
  GroundCourse course;
  std::uint32_t cost = UINT32_MAX;
  const double before = ground_cpu_ms();
  double last = before;
  course.state = ground.path.begin(ground.map, start, goal);
  while (course.state == planner::GroundPathState::running ||
         course.state == planner::GroundPathState::found) {
    course.state = ground.path.run(ground.map, 500);
    const double now = ground_cpu_ms();
    course.worst_slice_ms = std::max(course.worst_slice_ms, now - last);
    last = now;
    if (ground.path.cost() >= cost) continue;
    cost = ground.path.cost();
    course.steps.push_back({now - before, cost_seconds(cost), ground.path.work().units});
  }
  course.end_ms = last - before;
  course.end_units = ground.path.work().units;
  course.expanded = ground.path.work().expanded;
  return course;
}

double reached_ms(const std::vector<CourseStep>& steps, double cost_s) {
  for (const CourseStep& step : steps)
    if (step.cost_s <= cost_s) return step.ms;
  return -1.0;
}

}  // namespace sortie::bench
