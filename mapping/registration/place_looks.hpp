// SPDX-License-Identifier: BSD-3-Clause
// Whether two searches from places apart say the same of a lost robot.
#pragma once

#include <algorithm>

#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/place_judge.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"

namespace sortie::mapping {

/// How far two looks are apart.
struct PlaceLooksConfig {
  double second_look_m{2.0};  ///< 0.5 confirmed a wrong place once in 3,000 (docs/registration.md)
  double far_look_m{6.0};

  SORTIE_KEYS(c, key) {
    key("second_look_m", c.second_look_m,
        {0, 10, "m", "of way between two searches that have to agree; 0: one is enough"});
    key("far_look_m", c.far_look_m,
        {0, 100, "m", "the same, where one of the two is not sure (surely_over_unexplained)"});
  }
};

/// Looks, and what became of them.
struct PlaceLooksCounts {
  std::uint64_t first_looks{};  ///< places that wait for a second search that agrees
  std::uint64_t disagreed{};    ///< second searches that found another place
  SORTIE_FIELDS(first_looks, disagreed)
};

/// Keeps the last place that a search found, until another search, from far enough away, finds the odometry
/// at the same place on the map. What looks like another place looks less like it from a second one; where
/// it leaves much unexplained, from one further on. No memory but its own, no heap; some hundred operations a
/// look.
class PlaceLooks {
 public:
  explicit PlaceLooks(const PlaceLooksConfig& config) : config_(config) {}

  /// Takes what a search found that placed the robot, and the odometry's pose of its scan. True: a search
  /// before agrees; the looks begin anew. Without odometry nobody knows how far two searches are apart: the
  /// caller has to do with one.
  bool take(const JudgedPlace& found, const RigidPose& T_odom_sensor) {
    if (config_.second_look_m <= 0.0) return true;
    const RigidPose T_map_odom = after(found.T_map_sensor, inverse(T_odom_sensor));
    const RigidPose apart = after(inverse(T_map_odom_), T_map_odom);
    // Where the odometry's origin is far off, a small turn moves it far: both are compared at the robot.
    const rt::Vector3 here = T_odom_sensor.p;
    const rt::Vector3 off = apart.p + rt::rotate(apart.q, here) - here;
    const bool same =
        has_look_ && rt::norm(off) < kSameMove && rt::norm(rt::log_rotation(apart.q)) < kSameTurn;
    const double way_m =
        found.sure && is_sure_ ? config_.second_look_m : std::max(config_.second_look_m, config_.far_look_m);
    if (same && rt::norm(here - T_odom_sensor_.p) >= way_m) {
      has_look_ = false;
      return true;
    }
    if (same && (is_sure_ || !found.sure)) return false;
    if (has_look_ && !same) ++counts_.disagreed;
    if (!same) ++counts_.first_looks;
    has_look_ = true;
    is_sure_ = found.sure;
    T_odom_sensor_ = T_odom_sensor;
    T_map_odom_ = T_map_odom;
    return false;
  }
  const PlaceLooksCounts& counts() const { return counts_; }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "looks")
        .fixed(config_)
        .state(has_look_, is_sure_, T_odom_sensor_, T_map_odom_, counts_);
    check_pose(archive, T_odom_sensor_);
    check_pose(archive, T_map_odom_);
  }

 private:
  static constexpr double kSameMove = 0.3;  ///< m and rad: two searches agree, the odometry's drift included
  static constexpr double kSameTurn = 0.05;

  PlaceLooksConfig config_;
  bool has_look_{};  ///< a search found a place, and waits for another one that agrees
  bool is_sure_{};
  RigidPose T_odom_sensor_;  ///< of its scan
  RigidPose T_map_odom_;
  PlaceLooksCounts counts_;
};

}  // namespace sortie::mapping
