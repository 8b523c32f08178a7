// SPDX-License-Identifier: BSD-3-Clause
// Steering, scripts and the grid of them.
#include "hil/plant/course_drivers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/rotation.hpp"

namespace sortie::hil {
namespace {

constexpr double kSpeedUp_m_s2 = 0.5;
constexpr double kHalfSpan_m = 0.1985;

void set_pairs(const PairAngles& angles, PlantCommand& command) {
  for (int f = 0; f < kFlippers; ++f) command.flipper_rad[f] = f < 2 ? angles.front_rad : angles.rear_rad;
}

constexpr NamedPosture kPostures[] = {
    {"I", {0.0, 0.0}},       // stretched
    {"L", {0.7, 0.0}},       // front up
    {"V", {0.8, 0.8}},       // both up
    {"U", {1.4, 1.4}},       // both upright
    {"folded", {2.4, 2.4}},  // on the body
    {"N", {-0.4, -0.4}},     // on its toes
    {"L low", {0.4, 0.0}},  {"L, rear down", {0.6, -0.4}},
};

constexpr double kBefore[] = {0.0, 0.5, 1.0};
constexpr double kAfterFront[] = {-0.8, -0.3, 0.3};
constexpr double kAfterRear[] = {0.0, -0.5};
constexpr double kSwitch_m[] = {0.0, 0.35};
constexpr std::size_t kGrid = 3 * 3 * 2 * 2 + 1;

constexpr std::array<FlipperScript, kGrid> make_grid() {
  std::array<FlipperScript, kGrid> grid{};
  std::size_t n = 0;
  for (const double before : kBefore)
    for (const double front : kAfterFront)
      for (const double rear : kAfterRear)
        for (const double where : kSwitch_m) grid[n++] = {{before, 0.0}, {front, rear}, where};
  grid[n] = fixed_posture({2.4, 2.4});
  return grid;
}
constexpr std::array<FlipperScript, kGrid> kScripts = make_grid();

}  // namespace

void LineKeeper::begin(const Course& course) {
  start_x_ = course.start_m.x;
  start_y_ = course.start_m.y;
  const double dx = course.goal_x_m - start_x_, dy = course.goal_y_m - start_y_;
  const double length = std::sqrt(dx * dx + dy * dy);
  ux_ = dx / length;
  uy_ = dy / length;
  speed_m_s_ = last_s_ = 0.0;
}

double LineKeeper::along_m(const Vec3& p_world_m) const {
  return ux_ * (p_world_m.x - start_x_) + uy_ * (p_world_m.y - start_y_);
}

void LineKeeper::steer(const DriverView& view, double speed_m_s, PlantCommand& command) {
  const double room = kSpeedUp_m_s2 * (view.time_s - last_s_);
  last_s_ = view.time_s;
  speed_m_s_ += std::clamp(speed_m_s - speed_m_s_, -room, room);
  const double off = ux_ * (view.p_world_m.y - start_y_) - uy_ * (view.p_world_m.x - start_x_);
  const Vec3 ahead = rotate(view.q_world_body, {1, 0, 0});
  const double heading = rt::atan2(ux_ * ahead.y - uy_ * ahead.x, ux_ * ahead.x + uy_ * ahead.y);
  const double turn = std::clamp(2.0 * (std::clamp(-1.5 * off, -0.4, 0.4) - heading), -0.4, 0.4);
  // At no speed nothing turns either: a vehicle that is to stand stands.
  const double share = speed_m_s_ / 0.25;
  command.left_m_s = speed_m_s_ - kHalfSpan_m * turn * share;
  command.right_m_s = speed_m_s_ + kHalfSpan_m * turn * share;
}

void ScriptDriver::begin(const Course& course) {
  line_.begin(course);
  switch_m_ = course.obstacle_m - course.start_m.x + script_.switch_m;
}

DriverOrder ScriptDriver::drive(const DriverView& view) {
  DriverOrder order;
  line_.steer(view, script_.speed_m_s, order.command);
  set_pairs(line_.along_m(view.p_world_m) < switch_m_ ? script_.before : script_.after, order.command);
  return order;
}

std::span<const NamedPosture> fixed_postures() { return kPostures; }

std::span<const FlipperScript> script_grid() { return kScripts; }

bool grid_passes(const Course& course, const JudgeConfig& config) {
  return std::any_of(kScripts.begin(), kScripts.end(), [&](const FlipperScript& script) {
    ScriptDriver driver(script);
    return judge_course(course, driver, config).end == CourseEnd::reached;
  });
}

}  // namespace sortie::hil
