// SPDX-License-Identifier: BSD-3-Clause
// The operator by script.
#include <algorithm>
#include <cmath>

#include "hil/plant/course_drivers.hpp"
#include "rt/rotation.hpp"

namespace sortie::hil {
namespace {

constexpr double kDecides_s = 0.25;
constexpr double kStep_rad = 0.1;
constexpr double kClear_m = 0.02;   ///< above the ground that a flipper is laid along
constexpr double kAhead_m = 0.15;   ///< the ground so much further on counts already
constexpr double kLate_rad = 0.35;  ///< a flipper that far off is late
constexpr double kFast_m_s = 0.25;
constexpr double kSlow_m_s = 0.1;
constexpr double kClimbs_rad = 0.2;   ///< a nose higher than that climbs
constexpr double kSteep_rad = 0.3;    ///< and there the rear pair pushes
constexpr double kPush_rad = -0.4;    ///< to this angle
constexpr double kGivesUp_rad = 0.9;  ///< a body that leans more is not driven on

}  // namespace

void OperatorDriver::begin(const Course& course) {
  course_ = &course;
  line_.begin(course);
  command_ = {};
  next_s_ = 0.0;
}

double OperatorDriver::wanted_angle(const DriverView& view, int flipper) const {
  const double out = flipper < 2 ? 1.0 : -1.0;  // which way it points along the body
  const Vec3& joint = vehicle_.flipper_pivot_m;
  const Vec3 pivot = view.p_world_m + rotate(view.q_world_body,
                                             {out * joint.x, flipper % 2 == 0 ? joint.y : -joint.y, joint.z});
  const Vec3 ahead = rotate(view.q_world_body, {1, 0, 0});
  const double flat = std::sqrt(ahead.x * ahead.x + ahead.y * ahead.y);
  const double dx = out * ahead.x / flat, dy = out * ahead.y / flat;
  double steepest = -1.5;
  for (const double shift : {0.0, kAhead_m}) {
    if (shift > 0.0 && flipper >= 2) continue;  // what comes under the rear pair has been under the front
    for (double s = 0.06; s <= vehicle_.flipper_length_m + 0.03; s += 0.03) {
      const double share = s / vehicle_.flipper_length_m;
      const double thick = vehicle_.flipper_large_radius_m +
                           share * (vehicle_.flipper_small_radius_m - vehicle_.flipper_large_radius_m);
      const double ground = course_->height(pivot.x + (s + shift) * dx, pivot.y + (s + shift) * dy);
      steepest = std::max(steepest, rt::atan2(ground + thick + kClear_m - pivot.z, s));
    }
  }
  const double nose_up = rt::asin(std::clamp(ahead.z, -1.0, 1.0));
  double angle = steepest - out * nose_up;
  // Behind a climbing body the pair is held straight and then pushes, where lying along would let it fall
  // back.
  if (flipper >= 2 && nose_up > kClimbs_rad) angle = nose_up > kSteep_rad ? kPush_rad : std::min(angle, 0.0);
  const double whole = kStep_rad * rt::floor(angle / kStep_rad + 0.5);
  return std::clamp(whole, -0.8, 0.6);
}

DriverOrder OperatorDriver::drive(const DriverView& view) {
  if (view.time_s >= next_s_ || view.time_s == 0.0) {
    next_s_ = view.time_s + kDecides_s;
    // Both sides alike: one lever for a pair.
    command_.flipper_rad[0] = command_.flipper_rad[1] =
        std::max(wanted_angle(view, 0), wanted_angle(view, 1));
    command_.flipper_rad[2] = command_.flipper_rad[3] =
        std::max(wanted_angle(view, 2), wanted_angle(view, 3));
  }
  double late = 0.0;
  for (int f = 0; f < kFlippers; ++f)
    late = std::max(late, std::fabs(command_.flipper_rad[f] - view.flipper_rad[f]));
  line_.steer(view, late > kLate_rad ? kSlow_m_s : kFast_m_s, command_);
  DriverOrder order;
  order.command = command_;
  order.refuse = rotate(view.q_world_body, {0, 0, 1}).z < rt::cos(kGivesUp_rad);
  return order;
}

}  // namespace sortie::hil
