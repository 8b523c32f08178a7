// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_control/goal_profile.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::planner {
namespace {

using rt::Vector3;

constexpr double kFarthest_m = 1e4;

std::uint32_t whole_periods(double time_s, double period_s) {
  const double count =
      std::clamp(-rt::floor(1e-9 - time_s / period_s), 1.0, static_cast<double>(GoalProfile::kWindow - 1));
  return static_cast<std::uint32_t>(count);
}

// The greatest s in 0..1 with |s w - o| <= most, from the squares of w and o and their product; |o| <= most.
double most_share(double ww, double wo, double oo, double most) {
  if (!(ww > 1e-18)) return 1.0;
  const double square = std::max(0.0, wo * wo - ww * (oo - most * most));
  return std::clamp((wo + std::sqrt(square)) / ww, 0.0, 1.0);
}

}  // namespace

GoalProfile::GoalProfile(const ProfileLimits& limits, double period_s) : limits_(limits), dt_(period_s) {
  window_[0] = whole_periods(limits.speed_m_s / limits.acceleration_m_s2, period_s);
  window_[1] = whole_periods(limits.smoothing_s[0], period_s);
  window_[2] = whole_periods(limits.smoothing_s[1], period_s);
  rest({}, 0.0);
}

void GoalProfile::rest(const Vector3& p_m, double yaw_rad) {
  stand(p_m, yaw_rad);
  goal_m_ = p_m;
  goal_yaw_rad_ = yaw_rad;
}

void GoalProfile::stand(Vector3 p_m, double yaw_rad) {
  run_.fill({});
  first_.fill({});
  second_.fill({});
  for (Vector3& average : average_m_s_) average = {};
  brake_left_ = 0;
  still_ = kWindow * 3;
  now_ = {};
  now_.p_m = run_m_ = p_m;
  now_.yaw_rad = yaw_rad;
}

void GoalProfile::brake(const FlatReference& from) {
  stand(from.p_m, from.yaw_rad);
  now_ = from;
  brake_from_ = from;
  brake_from_.s_m_s4 = {};
  now_.s_m_s4 = {};
  // The cubic that takes v to 0 turns at most 1.5 v / T; an acceleration that is there fades over T as well.
  const double need_s = std::max(1.5 * rt::norm(from.v_m_s) / limits_.acceleration_m_s2,
                                 2.0 * (limits_.smoothing_s[0] + limits_.smoothing_s[1]));
  const double steps = std::clamp(-rt::floor(-need_s / dt_), 1.0, 1e6);
  brake_left_ = static_cast<std::uint32_t>(steps);
  brake_length_s_ = dt_ * steps;
  brake_time_s_ = 0.0;
}

Status GoalProfile::set_goal(const Vector3& p_m, double yaw_rad) {
  if (!rt::is_finite(p_m) || !std::isfinite(yaw_rad)) return Status::not_finite;
  if (std::max({std::fabs(p_m.x), std::fabs(p_m.y), std::fabs(p_m.z)}) > kFarthest_m ||
      std::fabs(yaw_rad) > 1e6)
    return Status::out_of_range;
  goal_m_ = p_m;
  goal_yaw_rad_ = yaw_rad;
  return Status::ok;
}

void GoalProfile::stop() {
  // What the averages still hold is run out; the straight run itself ends here. A brake goes on to its end.
  const double length = brake_length_s_;
  goal_m_ = brake_left_ > 0
                ? brake_from_.p_m + length * (0.5 * brake_from_.v_m_s + (length / 12) * brake_from_.a_m_s2)
                : run_m_;
  goal_yaw_rad_ = now_.yaw_rad;
}

Vector3 GoalProfile::run_velocity() const {
  const Vector3 way = goal_m_ - run_m_;
  const double across = std::sqrt(way.x * way.x + way.y * way.y);
  const double speed = std::max(1e-3, speed_share_ * limits_.speed_m_s);
  const double climb = std::max(1e-3, speed_share_ * limits_.climb_m_s);
  const double time_s = std::max({across / speed, std::fabs(way.z) / climb, dt_});
  const Vector3 wish = (1.0 / time_s) * way;
  // The first average makes an acceleration of what changes over its window: a run that turns round waits
  // until the old one is out of it. Along the wish, so that the goal is never passed.
  const Vector3& old = run_[(head_ + kWindow + 1 - window_[0]) % kWindow];
  const double share =
      std::min(most_share(wish.x * wish.x + wish.y * wish.y, wish.x * old.x + wish.y * old.y,
                          old.x * old.x + old.y * old.y, limits_.speed_m_s),
               most_share(wish.z * wish.z, wish.z * old.z, old.z * old.z, limits_.climb_m_s));
  return share * wish;
}

void GoalProfile::step_run() {
  const auto back = [this](std::uint32_t n) { return (head_ + kWindow - n) % kWindow; };
  // The chain as it stands now, then its exact course over one period: each average's rate is the difference
  // of its input over its window.
  const double per[3] = {1.0 / (dt_ * window_[0]), 1.0 / (dt_ * window_[1]), 1.0 / (dt_ * window_[2])};
  const Vector3 run = brake_left_ > 0 ? Vector3{} : run_velocity();
  still_ = rt::dot(run, run) > 0.0 ? 0 : std::min(still_ + 1, 3 * kWindow);
  head_ = (head_ + 1) % kWindow;
  run_[head_] = run;
  first_[head_] = {average_m_s_[0], {}};
  second_[head_] = {average_m_s_[1], {}, {}};
  if (still_ > window_[0] + window_[1] + window_[2]) {
    for (Vector3& average : average_m_s_) average = {};
    now_.p_m = run_m_;
    now_.v_m_s = now_.a_m_s2 = now_.j_m_s3 = now_.s_m_s4 = {};
    return;
  }
  const Vector3 a1 = per[0] * (run - run_[back(window_[0])]);
  const First& old1 = first_[back(window_[1])];
  const Vector3 a1_old = old1.a;
  first_[head_].a = a1;
  const Vector3 a2 = per[1] * (average_m_s_[0] - old1.v);
  const Vector3 j2 = per[1] * (a1 - a1_old);
  const Second& old2 = second_[back(window_[2])];
  second_[head_].a = a2;
  second_[head_].j = j2;
  const Vector3 a3 = per[2] * (average_m_s_[1] - old2.v);
  const Vector3 j3 = per[2] * (a2 - old2.a);
  const Vector3 s3 = per[2] * (j2 - old2.j);
  const double h = dt_;
  run_m_ = rt::norm(goal_m_ - run_m_ - h * run) < 1e-12 ? goal_m_ : run_m_ + h * run;
  now_.p_m = now_.p_m + h * (average_m_s_[2] + (h / 2) * (a3 + (h / 3) * (j3 + (h / 4) * s3)));
  average_m_s_[0] = average_m_s_[0] + h * a1;
  average_m_s_[1] = average_m_s_[1] + h * (a2 + (h / 2) * j2);
  average_m_s_[2] = average_m_s_[2] + h * (a3 + (h / 2) * (j3 + (h / 3) * s3));
  now_.v_m_s = average_m_s_[2];
  now_.a_m_s2 = a3 + h * (j3 + (h / 2) * s3);
  now_.j_m_s3 = j3 + h * s3;
  now_.s_m_s4 = s3;
}

void GoalProfile::step_brake() {
  // v(t) = v0 (1 + 2 s)(1 - s)^2 + a0 T s (1 - s)^2: a cubic with both ends' values and slopes.
  brake_time_s_ += dt_;
  --brake_left_;
  const double length = brake_length_s_;
  const double s = std::min(1.0, brake_time_s_ / length);
  const double s2 = s * s;
  const double s3 = s2 * s;
  const Vector3& v0 = brake_from_.v_m_s;
  const Vector3 a0 = length * brake_from_.a_m_s2;
  now_.p_m = brake_from_.p_m +
             length * ((s - s3 + 0.5 * s3 * s) * v0 + (0.5 * s2 - (2.0 / 3.0) * s3 + 0.25 * s3 * s) * a0);
  now_.v_m_s = (1.0 - 3.0 * s2 + 2.0 * s3) * v0 + (s - 2.0 * s2 + s3) * a0;
  now_.a_m_s2 = (1.0 / length) * ((6.0 * s2 - 6.0 * s) * v0 + (1.0 - 4.0 * s + 3.0 * s2) * a0);
  now_.j_m_s3 = (1.0 / (length * length)) * ((12.0 * s - 6.0) * v0 + (6.0 * s - 4.0) * a0);
  now_.s_m_s4 = {};
  if (brake_left_ == 0) {
    const double yaw_rate = now_.yaw_rate_rad_s;
    stand(now_.p_m, now_.yaw_rad);
    now_.yaw_rate_rad_s = yaw_rate;
  }
}

void GoalProfile::step_yaw() {
  // The shorter way round, with limited rate and acceleration; the square root lets it stop in the goal.
  const double left = rt::wrap_angle(goal_yaw_rad_ - now_.yaw_rad);
  const double most = limits_.turn_acceleration_rad_s2;
  const double brakes = std::sqrt(1.6 * most * std::fabs(left));
  const double wish =
      std::copysign(std::min({limits_.turn_rad_s, brakes, std::fabs(left) / (4.0 * dt_)}), left);
  const double rate = std::clamp(wish, now_.yaw_rate_rad_s - most * dt_, now_.yaw_rate_rad_s + most * dt_);
  now_.yaw_acceleration_rad_s2 = (rate - now_.yaw_rate_rad_s) / dt_;
  now_.yaw_rad = rt::wrap_angle(now_.yaw_rad + 0.5 * dt_ * (rate + now_.yaw_rate_rad_s));
  now_.yaw_rate_rad_s = rate;
}

void GoalProfile::step() {
  step_yaw();
  if (brake_left_ > 0) {
    step_brake();
  } else {
    step_run();
  }
}

}  // namespace sortie::planner
