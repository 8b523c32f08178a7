// SPDX-License-Identifier: BSD-3-Clause
// Places that segments or images say, held against a scan, and what a lost robot is told of them.
#pragma once

#include "firmware_like/parts/lost_robot.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/place_judge.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "rt/archive.hpp"

namespace sortie::firmware {

/// What every channel of recognition has its places checked by: the newest scan is matched at each of them on
/// the map of `locate` and judged, and a lost robot is placed where two looks agree. T_known_odom of a place:
/// the odometry's world on the known map. Memory: that of a PlaceJudge. No heap.
class PlaceCheck {
 public:
  /// `access`: of a locator that began with a map; it outlives this. `second_look_m`: as of LostRobot.
  PlaceCheck(const mapping::RelocateConfig& config, LocateAccess& access, double second_look_m,
             rt::Arena& arena)
      : access_(&access),
        judge_(config, access.locator->registration_to_match(), arena),
        lost_(second_look_m) {}

  /// Once a job. True: a place that a lost robot was told is taken back, since no scan confirmed it.
  bool wait() { return lost_.wait(*access_->locator, access_->scans); }
  /// This job has a scan to hold places against.
  bool has_scan() const { return access_->scans > 0 && access_->locator->registration().is_taken(); }
  /// Begins with that scan and no place. False: it cannot be judged by.
  [[nodiscard]] bool begin() {
    T_odom_judged_ = access_->hint.T_odom_sensor;
    return access_->has_odometry && mapping::is_pose(T_odom_judged_) &&
           judge_.begin(access_->locator->registration().sample(), access_->q_level_sensor);
  }
  /// Adds a place, the best one or one that it is compared with, before the first run().
  void add(const mapping::RigidPose& T_known_odom) { judge_.add(at(T_known_odom)); }
  /// Goes on for at most `units`, those of PlaceJudge. True: `judged` is the answer.
  bool run(std::uint64_t& units, mapping::JudgedPlace& judged) { return judge_.run(units, judged); }

  /// The scan fits on one place alone, and that is the one of `T_known_odom`.
  bool confirms(const mapping::JudgedPlace& judged, const mapping::RigidPose& T_known_odom) const {
    return judged.verdict == mapping::RelocateVerdict::placed &&
           !mapping::are_apart(judged.T_map_sensor, at(T_known_odom), kSameMove, kSameTurn);
  }
  /// T_known_odom as the scan has it.
  mapping::RigidPose tie(const mapping::JudgedPlace& judged) const {
    return mapping::after(judged.T_map_sensor, mapping::inverse(T_odom_judged_));
  }
  /// A look of a robot that may be lost. True: it was told this place.
  bool look(const mapping::JudgedPlace& judged) {
    return lost_.look(*access_->locator, judged, T_odom_judged_);
  }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "place check").fixed(access_).state(T_odom_judged_, lost_, judge_);
    mapping::check_pose(archive, T_odom_judged_);
  }

 private:
  /// T_known_sensor of the scan that is judged.
  mapping::RigidPose at(const mapping::RigidPose& T_known_odom) const {
    return mapping::after(T_known_odom, T_odom_judged_);
  }

  static constexpr double kSameMove = 1.0;  ///< m: where a scan fits is where the channel says
  static constexpr double kSameTurn = 0.2;  ///< rad

  LocateAccess* access_;
  mapping::PlaceJudge judge_;
  mapping::RigidPose T_odom_judged_;  ///< of the scan that is judged
  LostRobot lost_;
};

}  // namespace sortie::firmware
