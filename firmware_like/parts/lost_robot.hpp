// SPDX-License-Identifier: BSD-3-Clause
// What a robot that is lost on a kept map is told of its place, where its segments were recognised.
#pragma once

#include <cstdint>

#include "mapping/registration/locator.hpp"
#include "mapping/registration/place_looks.hpp"
#include "rt/archive.hpp"

namespace sortie::firmware {

/// Hands a locator that is unplaced a place on which two looks from places apart agree, and takes it back
/// where no scan confirms it, so that the robot is lost again and not stuck. A look has few places to compare
/// with, so none of them is sure. No memory but its own, no heap.
class LostRobot {
 public:
  /// `second_look_m`: of way between the two looks; 0: one is enough.
  explicit LostRobot(double second_look_m) : looks_({second_look_m, second_look_m}) {}

  /// Once a job, with its scans. True: a place was taken back that none of kPatience scans confirmed.
  bool wait(mapping::Locator& locator, std::uint32_t scans) {
    if (!told_) return false;
    waited_ += scans;
    if (!locator.has_begun() && waited_ < kPatience) return false;
    told_ = false;
    if (locator.has_begun()) return false;
    locator.take_back();
    return true;
  }

  /// A look: a scan was placed there, and `T_odom_sensor` is the odometry's pose of that scan. True: the
  /// locator was told, and its next scan decides. Of a robot that is not lost nothing is taken.
  bool look(mapping::Locator& locator, mapping::JudgedPlace found, const mapping::RigidPose& T_odom_sensor) {
    found.sure = false;
    if (!locator.is_unplaced() || !looks_.take(found, T_odom_sensor)) return false;
    for (int i = 0; i < 3; ++i) {
      found.covariance[7 * i] += kLeastMove * kLeastMove;
      found.covariance[7 * (i + 3)] += kLeastTurn * kLeastTurn;
    }
    mapping::OdometryHint hint;
    hint.known = true;
    hint.T_odom_sensor = T_odom_sensor;
    told_ = locator.place(found.T_map_sensor, found.covariance, hint) == Status::ok;
    waited_ = 0;
    return told_;
  }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "lost robot").state(looks_, told_, waited_);
  }

 private:
  static constexpr std::uint32_t kPatience = 5;  ///< scans that may fail to confirm a place
  static constexpr double kLeastMove = 0.1;      ///< m: what the locator is told at least that a place is off
  static constexpr double kLeastTurn = 0.03;     ///< rad

  mapping::PlaceLooks looks_;
  bool told_{};             ///< the locator was told a place, and no scan has confirmed it yet
  std::uint32_t waited_{};  ///< scans since
};

}  // namespace sortie::firmware
