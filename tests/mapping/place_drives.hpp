// SPDX-License-Identifier: BSD-3-Clause
// Lost robots that drive on and search again, until they are placed or have looked twenty times.
#pragma once

#include <algorithm>

#include "tests/mapping/place_trials.hpp"

namespace sortie::testing {

/// Of robots that drive on and look again and again: how many looks it took to place each.
struct DriveTally {
  static constexpr int kLooks = 20;  ///< at most, of a drive
  int right{}, wrong{}, lost{};
  int looks{};                ///< of all
  std::vector<int> looks_of;  ///< of each that was placed
  long within(int most) const {
    return std::count_if(looks_of.begin(), looks_of.end(), [most](int one) { return one <= most; });
  }
};

/// A robot that drives straight on while there is room, else to where of some directions there is most; its
/// odometry drifts by 1 % of the way and 0.2 degrees a metre.
class DrivingRobot {
 public:
  DrivingRobot(const PlaceWorld& world, const LostRobot& start, Draws& draws)
      : world_(world),
        truth_(start.pose),
        odom_(start.pose),
        heading_(draws.uniform(-M_PI, M_PI)),
        drift_(draws.uniform(-M_PI, M_PI)) {}

  /// Drives `way_m`, as far as it can.
  void drive(double way_m, Draws& draws) {
    for (double at = 0; at < way_m - 1e-9; at += kStep) {
      if (!is_free(truth_.p + kStep * ahead(heading_))) heading_ = widest(draws);
      if (!is_free(truth_.p + kStep * ahead(heading_))) return;
      truth_.p = truth_.p + kStep * ahead(heading_);
      turned_ += kStep * 0.0035;
      const rt::Quaternion off = rt::exp_rotation({0, 0, turned_});
      odom_.p = odom_.p + kStep * (rt::rotate(off, ahead(heading_)) + 0.01 * ahead(drift_));
    }
  }
  /// Turned and tilted as a lost robot is.
  void turn(Draws& draws) {
    const LostRobot other(world_, draws);
    truth_.q = other.pose.q;
    q_level_sensor_ = other.q_level_sensor;
    odom_.q = rt::normalised(rt::exp_rotation({0, 0, turned_}) * truth_.q);
  }
  const rt::Quaternion& q_level_sensor() const { return q_level_sensor_; }
  const mapping::RigidPose& truth() const { return truth_; }
  const mapping::RigidPose& T_odom_sensor() const { return odom_; }

 private:
  static constexpr double kStep = 0.25;
  static rt::Vector3 ahead(double heading) { return {std::cos(heading), std::sin(heading), 0}; }
  double widest(Draws& draws) const {
    double best = 0.0, most_m = -1.0;
    for (int i = 0; i < 16; ++i) {
      const double heading = draws.uniform(-M_PI, M_PI);
      double free_m = 0.0;
      while (free_m < 12.0 && is_free(truth_.p + (free_m + kStep) * ahead(heading))) free_m += kStep;
      if (free_m > most_m) most_m = free_m, best = heading;
    }
    return best;
  }
  bool is_free(const rt::Vector3& p) const {
    return p.x > 0.3 && p.x < world_.wide - 0.3 && p.y > 0.3 && p.y < world_.deep - 0.3 &&
           world_.is_free(p, 0.3);
  }
  const PlaceWorld& world_;
  mapping::RigidPose truth_, odom_;
  rt::Quaternion q_level_sensor_{};
  double heading_, drift_, turned_{};
};

/// One drive of at most twenty searches, 1.5 m apart, as part `relocate` searches.
inline void drive_until_placed(PlaceRig& rig, const PlaceWorld& seen, Draws& draws, DriveTally& tally) {
  DrivingRobot robot(seen, LostRobot(seen, draws), draws);
  mapping::PlaceLooks looks{{}};
  for (int look = 1; look <= DriveTally::kLooks; ++look) {
    robot.turn(draws);
    const mapping::RigidPose& truth = robot.truth();
    const mapping::Relocated& found =
        rig.find(place_scan(random_lidar(draws), seen, truth.p, truth.q, draws), robot.q_level_sensor());
    ++tally.looks;
    if (found.verdict == mapping::RelocateVerdict::placed && looks.take(found, robot.T_odom_sensor())) {
      const rt::Quaternion turn = truth.q * rt::conjugate(found.T_map_sensor.q);
      const bool right =
          rt::norm(truth.p - found.T_map_sensor.p) < 0.1 && rt::norm(rt::log_rotation(turn)) < 0.01745;
      ++(right ? tally.right : tally.wrong);
      tally.looks_of.push_back(look);
      return;
    }
    robot.drive(1.5, draws);
  }
  ++tally.lost;
}

/// Drives through sites.
inline DriveTally drives_on_site(PlaceRig& rig, std::uint64_t seed, int trials, double share_moved) {
  DriveTally tally;
  on_sites(rig, seed, trials, share_moved,
           [&](Draws& draws, const PlaceWorld& now) { drive_until_placed(rig, now, draws, tally); });
  return tally;
}

/// Drives through worlds in which a robot that is placed is placed by mistake.
inline DriveTally false_drives(PlaceRig& rig, FalsePlace kind, std::uint64_t seed, int trials) {
  DriveTally tally;
  for (int trial = 0; trial < trials; ++trial) {
    Draws draws(seed + static_cast<std::uint64_t>(trial));
    const PlaceWorld world = random_place_world(draws);
    rig.make_map(world, draws, 1.7);
    drive_until_placed(rig, kind == FalsePlace::mirrored ? mirrored(world) : random_place_world(draws), draws,
                       tally);
  }
  return tally;
}

}  // namespace sortie::testing
