// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/courses/mission_driver.hpp"

#include <algorithm>
#include <stdexcept>

#include "hil/plant/course_shapes.hpp"

namespace sortie::bench {
namespace {

constexpr double kSpeed_m_s = 0.25;
constexpr double kClimb_rad = 0.6981317007977318;  // 40 degrees

}  // namespace

void MissionDriver::begin(const hil::Course& course) {
  line_.begin(course);
  const planner::FlipperPosture modes[] = {{{kClimb_rad, kClimb_rad, 0.0, 0.0}}, {{0.0, 0.0, 0.0, 0.0}}};
  const bool down =
      course.family == hil::TerrainFamily::step_down || course.family == hil::TerrainFamily::stairs_down;
  planner::FlipperConfig config;
  config.initial = down ? 1 : 0;
  postures_ = {};
  if (postures_.set_up(modes, config) != Status::ok) throw std::runtime_error("courses: no postures");
  // Over the obstacle: 0.2 m past its first edge, or 0.4 m before its last one, as the scenes' authors had
  // it.
  const double last_edge = course.goal_x_m - hil::kCourseTail_m;
  const double there = std::max(course.obstacle_m + 0.2, last_edge - 0.4) - course.start_m.x;
  flat_s_ = down ? 0.0 : 0.25 + there / kSpeed_m_s;
}

hil::DriverOrder MissionDriver::drive(const hil::DriverView& view) {
  hil::DriverOrder order;
  line_.steer(view, kSpeed_m_s, order.command);
  const auto now = static_cast<rt::Nanoseconds>(view.time_s * 1e9 + 0.5);
  const Status status = postures_.update(view.time_s >= flat_s_ ? 1 : 0, false, now);
  if (status != Status::ok && status != Status::time_repeated) throw std::runtime_error("courses: no angles");
  std::copy_n(postures_.output().angle_rad, hil::kFlippers, order.command.flipper_rad);
  return order;
}

}  // namespace sortie::bench
