// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_way/ground_way_follower.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner {

namespace {

constexpr double kAstern_rad = 3.14159265358979323846;
constexpr double kTooFarAside_rad = 1.2;  // no step begins with the robot looking elsewhere

double chord_of(double dx, double dy) { return std::sqrt(dx * dx + dy * dy); }

}  // namespace

void GroundWayFollower::forget() {
  way_ = {};
  step_ = 0;
  arrived_ = lost_ = turning_ = reversing_ = watching_ = false;
}

void GroundWayFollower::take(const GroundWay& way, std::uint32_t goal) {
  if (way.goal != goal || way.steps > GroundWay::kMostSteps || arrived_) return;
  // The goal is where the robot stands.
  arrived_ = way.steps == 0 && way.whole != 0;
  if (way.series != way_.series) {
    way_ = way;
    step_ = way.first;
    lost_ = watching_ = false;
    return;
  }
  if (way.stamp_ns == way_.stamp_ns) return;
  // What is being driven was taken back while the robot came to it: it stands in the middle of that.
  const bool has_gone = step_ < end() && step_ >= way.first + way.steps;
  way_ = way;
  step_ = std::max(step_, way.first);
  if (has_gone) lose(counters_.off);
}

GroundWayFollower::Place GroundWayFollower::place(std::uint32_t step) const {
  const std::uint32_t i = step - way_.first;
  return {1e-3 * way_.x_mm[i], 1e-3 * way_.y_mm[i]};
}

WayMotion GroundWayFollower::motion(std::uint32_t step) const {
  return static_cast<WayMotion>(way_.motion[step - way_.first]);
}

/// The step after goes on in the same direction: nothing is to be reached exactly.
bool GroundWayFollower::goes_on(std::uint32_t step) const {
  return step + 1 < end() && motion(step + 1) == motion(step);
}

double GroundWayFollower::to_run_end(std::uint32_t step, double rest_m) const {
  for (; goes_on(step); ++step) {
    const Place a = place(step);
    const Place b = place(step + 1);
    rest_m += chord_of(b.x_m - a.x_m, b.y_m - a.y_m);
  }
  return rest_m;
}

/// The place `along_m` behind the step's begin, on its chord or on those that go on from it.
GroundWayFollower::Place GroundWayFollower::target(std::uint32_t step, double along_m) const {
  for (;; ++step) {
    const Place a = place(step - 1);
    const Place b = place(step);
    const double length = chord_of(b.x_m - a.x_m, b.y_m - a.y_m);
    if (along_m <= length || !goes_on(step)) {
      // Beyond the end, so that the robot arrives looking along the step.
      const double part = length > 0.0 ? along_m / length : 0.0;
      return {a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m)};
    }
    along_m -= length;
  }
}

void GroundWayFollower::lose(std::uint64_t& count) {
  ++count;
  lost_ = true;
  watching_ = false;
}

bool GroundWayFollower::is_stuck(double to_go, rt::Nanoseconds now_ns) {
  constexpr double kProgress = 0.03;  // m, or rad
  if (!watching_ || to_go < best_ - kProgress) {
    watching_ = true;
    best_ = to_go;
    since_ns_ = now_ns;
  }
  return static_cast<double>(now_ns - since_ns_) > 1e9 * config_.stuck_s;
}

SpeedTurn GroundWayFollower::wish(const rt::PoseEstimate& pose, const TwistLimits& limits,
                                  const TwistRamps& ramps, rt::Nanoseconds now_ns) {
  turning_ = reversing_ = false;
  if (lost_ || way_.steps < 2 || !rt::is_finite(rt::to_vector(pose.p_world_body_m)) ||
      !rt::is_finite(rt::to_quaternion(pose.q_world_body))) {
    watching_ = false;
    return {};
  }
  const double x_m = pose.p_world_body_m[0];
  const double y_m = pose.p_world_body_m[1];
  const double yaw = rt::yaw_of(rt::to_quaternion(pose.q_world_body));
  // Each round ends a step, or drives it.
  for (; step_ < end(); ++step_, ++counters_.steps, watching_ = false) {
    const Place to = place(step_);
    const WayMotion how = motion(step_);
    if (how == WayMotion::turn || how == WayMotion::begin) {
      const double error = rt::wrap_angle(1e-3 * way_.heading_mrad[step_ - way_.first] - yaw);
      if (chord_of(x_m - to.x_m, y_m - to.y_m) > config_.off_m || std::fabs(error) > kTooFarAside_rad) {
        lose(counters_.off);
        return {};
      }
      // Turns that follow each other are one.
      if (std::fabs(error) <= config_.reach_rad || (goes_on(step_) && std::fabs(error) < 0.3)) continue;
      turning_ = true;
      if (is_stuck(std::fabs(error), now_ns)) {
        lose(counters_.stuck);
        return {};
      }
      const double turn =
          std::clamp(config_.heading_gain_per_s * error, -limits.max_turn_rad_s, limits.max_turn_rad_s);
      return {0.0, turn};
    }
    const Place from = place(step_ - 1);
    const double dx = to.x_m - from.x_m;
    const double dy = to.y_m - from.y_m;
    const double length = chord_of(dx, dy);
    const double along = length > 0.0 ? ((x_m - from.x_m) * dx + (y_m - from.y_m) * dy) / length : 0.0;
    const double beside = length > 0.0 ? ((y_m - from.y_m) * dx - (x_m - from.x_m) * dy) / length : 0.0;
    if (std::fabs(beside) > config_.off_m || along < -config_.off_m || along > length + config_.off_m) {
      lose(counters_.off);
      return {};
    }
    if (along >= length - (goes_on(step_) ? 0.0 : config_.reach_m)) continue;
    reversing_ = how == WayMotion::reverse;
    const Place aim = target(step_, std::max(along, 0.0) + config_.look_ahead_m);
    double error = rt::wrap_angle(rt::atan2(aim.y_m - y_m, aim.x_m - x_m) - yaw);
    if (reversing_) error = rt::wrap_angle(error + kAstern_rad);
    if (std::fabs(error) > kTooFarAside_rad) {
      lose(counters_.off);
      return {};
    }
    const double rest_m = to_run_end(step_, length - along);
    if (is_stuck(rest_m, now_ns)) {
      lose(counters_.stuck);
      return {};
    }
    const double braking = std::sqrt(1.6 * ramps.speed.acceleration * std::max(rest_m - 0.02, 0.0));
    double speed = std::min(braking, limits.max_speed_m_s) * std::max(0.0, 1.0 - std::fabs(error) / 0.8);
    speed = std::max(speed, std::min(config_.creep_speed_m_s, limits.max_speed_m_s));
    const double turn =
        std::clamp(config_.heading_gain_per_s * error, -limits.max_turn_rad_s, limits.max_turn_rad_s);
    return {reversing_ ? -speed : speed, turn};
  }
  watching_ = false;
  arrived_ = way_.whole != 0;
  return {};
}

void GroundWayFollower::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "ground way follower")
      .fixed(config_)
      .state(way_, step_, arrived_, lost_, turning_, reversing_, watching_, best_, since_ns_, counters_);
  const bool is_on_it = way_.steps <= GroundWay::kMostSteps &&
                        (way_.steps == 0 || (step_ >= way_.first && step_ <= end() &&
                                             way_.motion[0] == static_cast<std::uint8_t>(WayMotion::begin)));
  if (!archive.is_reading() || is_on_it) return;
  archive.fail(Status::malformed, "a step that the way has not");
  forget();
}

}  // namespace sortie::planner
