// SPDX-License-Identifier: BSD-3-Clause
// Paths in time that benchmarks fly: straight legs from rest to rest on the polynomial of least snap.
#pragma once

#include <cmath>
#include <vector>

#include "planner/uav_control/flat_reference.hpp"

namespace sortie::bench {

/// Legs between corners; the heading turns along with each.
class LegPath {
 public:
  struct Corner {
    rt::Vector3 p_m;
    double yaw_rad{};
  };

  /// Each leg takes as long as its greatest speed, acceleration and turn need, and is followed by a rest.
  LegPath(std::vector<Corner> corners, double speed_m_s, double acceleration_m_s2, double wait_s);

  planner::FlatReference at(double time_s) const;
  double length_s() const { return end_s_; }

 private:
  std::vector<Corner> corners_;
  std::vector<double> start_s_;
  std::vector<double> leg_s_;
  double end_s_{};
};

/// A turn by 1.5 rad in place, then a rectangle of 3 x 2 m, flown round once with that heading; ten seconds
/// of it are spent in place.
LegPath rectangle(double speed_m_s, double acceleration_m_s2);

}  // namespace sortie::bench
