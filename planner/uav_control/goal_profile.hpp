// SPDX-License-Identifier: BSD-3-Clause
// Raw goals to a smooth motion toward them: limited in speed, acceleration, jerk and snap, whatever is asked.
#pragma once

#include <array>
#include <cstdint>

#include "planner/uav_control/flat_reference.hpp"
#include "rt/archive.hpp"
#include "rt/keys.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// Limits of the motion. Acceleration is speed over the first smoothing time, jerk acceleration over the
/// second (twice that while an acceleration turns round), snap jerk over the third (up to four times).
struct ProfileLimits {
  double speed_m_s{2.0};
  double climb_m_s{1.5};
  double acceleration_m_s2{4.0};
  double smoothing_s[2]{0.16, 0.16};  ///< second and third smoothing time
  double turn_rad_s{1.2};             ///< of the heading
  double turn_acceleration_rad_s2{4.0};

  SORTIE_KEYS(c, key) {
    key("speed_m_s", c.speed_m_s, {0.05, 10, "m/s", "most, across"});
    key("climb_m_s", c.climb_m_s, {0.05, 5, "m/s", "most, up and down"});
    key("acceleration_m_s2", c.acceleration_m_s2, {0.1, 10, "m/s2", "most of a goal's way"});
    key("turn_rad_s", c.turn_rad_s, {0.05, 6, "rad/s", "most of the heading"});
  }
};

/// A straight run at the greatest allowed speed, smoothed by three moving averages in a row, in exact steps:
/// the velocity is piecewise cubic and position, velocity, acceleration, jerk and snap belong together to
/// rounding. A chain of averages neither overshoots nor can be upset by goals that jump about. A vehicle that
/// is moving when it starts is first led to rest on a polynomial. 19 kB, no heap, fixed cost.
class GoalProfile {
 public:
  static constexpr std::uint32_t kWindow = 128;

  /// Smoothing times are rounded to whole periods and held within kWindow of them.
  GoalProfile(const ProfileLimits& limits, double period_s);

  /// At rest in `p_m` with `yaw_rad`.
  void rest(const rt::Vector3& p_m, double yaw_rad);
  /// Moving as `from` says (snap is not used); comes to rest within the limits as far as they allow.
  void brake(const FlatReference& from);
  /// Where to go from the next step on. not_finite or out_of_range (beyond 10 km): the goal before stays.
  [[nodiscard]] Status set_goal(const rt::Vector3& p_m, double yaw_rad);
  /// Slower or faster from the next step on; at most the configured speeds.
  void set_speed_share(double share) { speed_share_ = share; }
  /// Where it comes to rest when the goal is dropped now becomes the goal.
  void stop();

  /// One period on. About 150 operations.
  void step();
  const FlatReference& now() const { return now_; }
  const rt::Vector3& goal_m() const { return goal_m_; }
  double goal_yaw_rad() const { return goal_yaw_rad_; }

  /// State to bytes and back, into one of the same limits.
  void archive(rt::Archive& archive);

 private:
  // What an average has to remember of its input: with each further one a derivative more is continuous.
  struct First {
    rt::Vector3 v, a;
    SORTIE_FIELDS(v, a)
  };
  struct Second {
    rt::Vector3 v, a, j;
    SORTIE_FIELDS(v, a, j)
  };
  void stand(rt::Vector3 p_m, double yaw_rad);  // the goal stays
  rt::Vector3 run_velocity() const;
  void step_run();
  void step_brake();
  void step_yaw();

  ProfileLimits limits_;
  double dt_;
  std::uint32_t window_[3]{};
  std::array<rt::Vector3, kWindow> run_{};  ///< speeds of the straight run, newest at head_
  std::array<First, kWindow> first_{};
  std::array<Second, kWindow> second_{};
  rt::Vector3 average_m_s_[3];  ///< speeds after each average
  std::uint32_t head_{};
  std::uint32_t still_{};  ///< steps without a run
  rt::Vector3 run_m_;      ///< place of the straight run
  rt::Vector3 goal_m_;
  double goal_yaw_rad_{};
  double speed_share_{1.0};
  std::uint32_t brake_left_{};
  double brake_time_s_{};
  double brake_length_s_{};
  FlatReference brake_from_;
  FlatReference now_;
};

}  // namespace sortie::planner
