// SPDX-License-Identifier: BSD-3-Clause
// One drive in the plant, watched step by step.
#include "hil/plant/course_judge.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "rt/rotation.hpp"

namespace sortie::hil {
namespace {

constexpr double kWindow_s = 0.01;    ///< of the means whose peaks are taken
constexpr double kLoad_n = 0.5;       ///< a contact with less does not count
constexpr double kApart_s = 0.1;      ///< between two touches that count as two
constexpr double kBeyond_m = 0.02;    ///< past the first edge, on the ground of the start
constexpr double kProgress_m = 0.03;  ///< less is none

/// Watches contacts, rates and accelerations of a drive.
class Watch {
 public:
  Watch(const TrackedPlant& plant, const Course& course, double step_s)
      : plant_(&plant), obstacle_m_(course.obstacle_m), step_s_(step_s) {
    window_ = std::max(1, static_cast<int>(kWindow_s / step_s + 0.5));
    start_window();
  }

  /// Before the drive: what is stood on is no obstacle.
  void see_start() {
    CourseResult nobody;
    settling_ = true;
    see_contacts(nobody);
    settling_ = false;
  }

  /// After each step of the drive.
  void see(CourseResult& result) {
    see_contacts(result);
    rates_ += plant_->state().velocity.angular.y;
    if (++steps_ == window_) {
      const double climb = plant_->velocity_world_m_s({}).z;
      result.peak_pitch_rate_rad_s = std::max(result.peak_pitch_rate_rad_s, std::fabs(rates_) / window_);
      result.peak_vertical_m_s2 =
          std::max(result.peak_vertical_m_s2, std::fabs(climb - climb_) / (window_ * step_s_));
      start_window();
    }
  }

  /// Begins a mean anew.
  void start_window() {
    rates_ = 0.0;
    steps_ = 0;
    climb_ = plant_->velocity_world_m_s({}).z;
  }

 private:
  void see_contacts(CourseResult& result) {
    const Vec3 origin = plant_->p_world_body_m();
    bool belly = false;
    for (std::uint32_t i = 0; i < plant_->contacts().size(); ++i) {
      const ContactPoint& c = plant_->contacts()[i];
      if (norm(c.impulse_ns) < kLoad_n * step_s_) continue;
      belly = belly || plant_->tags()[i].part == 0;
      const Vec3 at = origin + rotate(plant_->state().q_world_body, c.point_m);
      const auto solid =
          static_cast<std::size_t>(plant_->tags()[i].object + static_cast<int>(PlantScene::kMaxHalfSpaces));
      if (settling_) start_ground_[solid] = true;
      result.touched = result.touched || !start_ground_[solid] || at.x > obstacle_m_ + kBeyond_m;
    }
    if (belly) {
      if (without_s_ >= kApart_s) ++result.belly_contacts;
      result.belly_s += step_s_;
      without_s_ = 0.0;
    } else {
      without_s_ += step_s_;
    }
  }

  const TrackedPlant* plant_;
  std::bitset<PlantScene::kMaxSolids + PlantScene::kMaxHalfSpaces> start_ground_;
  bool settling_{};
  double obstacle_m_;
  double step_s_;
  int window_{};
  int steps_{};
  double rates_{};
  double climb_{};
  double without_s_{kApart_s};
};

/// Start, goal and the ellipse around both.
struct Way {
  Way(const Course& course, const JudgeConfig& config) : goal_x(course.goal_x_m), goal_y(course.goal_y_m) {
    const double dx = goal_x - course.start_m.x, dy = goal_y - course.start_m.y;
    length = std::sqrt(dx * dx + dy * dy);
    if (!(length > 0.0)) throw std::runtime_error("hil course: start and goal are one place");
    ux = dx / length;
    uy = dy / length;
    middle_x = 0.5 * (goal_x + course.start_m.x);
    middle_y = 0.5 * (goal_y + course.start_m.y);
    half_along = 0.5 * length + config.along_m;
    half_across = 0.25 * length + config.across_m;
  }

  double to_go(const Vec3& p) const { return norm(Vec3{goal_x - p.x, goal_y - p.y, 0.0}); }
  bool outside(const Vec3& p) const {
    const double dx = p.x - middle_x, dy = p.y - middle_y;
    const double along = (ux * dx + uy * dy) / half_along;
    const double across = (ux * dy - uy * dx) / half_across;
    return along * along + across * across > 1.0;
  }
  /// Cosine of the heading's angle to the way, seen from above.
  double facing(const Quat& q) const {
    const Vec3 ahead = rotate(q, {1, 0, 0});
    const double flat = std::sqrt(ahead.x * ahead.x + ahead.y * ahead.y);
    return flat > 1e-9 ? (ux * ahead.x + uy * ahead.y) / flat : 1.0;
  }

  double goal_x, goal_y, length{}, ux{}, uy{}, middle_x{}, middle_y{}, half_along{}, half_across{};
};

DriverView view_of(const TrackedPlant& plant, double time_s) {
  DriverView view;
  view.time_s = time_s;
  view.p_world_m = plant.p_world_body_m();
  view.q_world_body = plant.state().q_world_body;
  view.v_world_m_s = plant.velocity_world_m_s({});
  view.w_body_rad_s = plant.state().velocity.angular;
  std::copy_n(plant.state().flipper_rad, kFlippers, view.flipper_rad);
  return view;
}

/// Pitch and roll of a body, without their signs.
struct Lean {
  explicit Lean(const Quat& q) {
    const rt::Quaternion turned{q.w, q.x, q.y, q.z};
    pitch = std::fabs(rt::pitch_of(turned));
    roll = std::fabs(rt::roll_of(turned));
  }
  bool tipped(const JudgeConfig& config) const {
    return pitch >= config.tipped_rad || roll >= config.tipped_rad;
  }
  double pitch{}, roll{};
};

void advance(TrackedPlant& plant, const PlantCommand& command, double step_s) {
  if (plant.step(command, step_s) != Status::ok)
    throw std::runtime_error("hil course: the driver orders what the plant does not take");
}

/// Belts stand, flippers are held: does it stay upright?
bool falls_over(TrackedPlant& plant, PlantCommand command, const JudgeConfig& config) {
  command.left_m_s = command.right_m_s = 0.0;
  for (double t = 0.0; t < config.settle_s; t += config.step_s) {
    advance(plant, command, config.step_s);
    if (Lean(plant.state().q_world_body).tipped(config)) return true;
  }
  return false;
}

}  // namespace

CourseResult judge_course(const Course& course, FlipperDriver& driver, const JudgeConfig& config) {
  const auto plant = std::make_unique<TrackedPlant>(plant_config(course), *course.scene);
  const Way way(course, config);
  driver.begin(course);
  DriverOrder order = driver.drive(view_of(*plant, 0.0));
  PlantCommand standing = order.command;
  standing.left_m_s = standing.right_m_s = 0.0;
  Watch watch(*plant, course, config.step_s);
  for (double t = 0.0; t < config.settle_s; t += config.step_s) {
    advance(*plant, standing, config.step_s);
    watch.see_start();
  }
  watch.start_window();
  CourseResult result;
  const double cos_turned = rt::cos(config.turned_rad);
  const double time_out_s = config.time_out_s + config.time_out_s_m * way.length;
  double nearest_m = std::numeric_limits<double>::infinity();
  double nearest_s = 0.0;
  for (std::int64_t k = 0;; ++k) {
    result.time_s = static_cast<double>(k) * config.step_s;
    const Vec3 p = plant->p_world_body_m();
    const Quat& q = plant->state().q_world_body;
    const Lean lean(q);
    result.peak_pitch_rad = std::max(result.peak_pitch_rad, lean.pitch);
    result.peak_roll_rad = std::max(result.peak_roll_rad, lean.roll);
    result.end_m = p;
    const double to_go = way.to_go(p);
    if (to_go < nearest_m - kProgress_m) {
      nearest_m = to_go;
      nearest_s = result.time_s;
    }
    const bool stuck = config.stuck_s > 0.0 && result.time_s - nearest_s > config.stuck_s;
    bool ended = true;
    if (lean.tipped(config))
      result.end = CourseEnd::tipped;
    else if (way.facing(q) < cos_turned)
      result.end = CourseEnd::turned;
    else if (to_go <= config.goal_m)
      result.end = CourseEnd::reached;
    else if (way.outside(p))
      result.end = CourseEnd::left;
    else if (result.time_s >= time_out_s || stuck)
      result.end = CourseEnd::timed_out;
    else
      ended = false;
    if (!ended && k % config.steps_per_order == 0) {
      order = driver.drive(view_of(*plant, result.time_s));
      if (order.refuse) {
        result.end = CourseEnd::refused;
        ended = true;
      }
    }
    if (ended) break;
    advance(*plant, order.command, config.step_s);
    watch.see(result);
  }
  // Who refuses with a foot in the air may fall over all the same.
  if (result.end == CourseEnd::refused && falls_over(*plant, order.command, config))
    result.end = CourseEnd::tipped;
  result.not_converged = plant->counters().not_converged;
  return result;
}

}  // namespace sortie::hil
