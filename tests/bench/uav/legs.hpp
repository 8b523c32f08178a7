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
  /// `reserve`: how much longer than that.
  LegPath(std::vector<Corner> corners, double speed_m_s, double acceleration_m_s2, double wait_s,
          double reserve);

  planner::FlatReference at(double time_s) const;
  double length_s() const { return end_s_; }

 private:
  std::vector<Corner> corners_;
  std::vector<double> start_s_;
  std::vector<double> leg_s_;
  double end_s_{};
};

/// What the description of the rectangle that Lee's figures elsewhere come from leaves open: "4 legs 3 x 2 m,
/// 1 m/s, yaw 1.5 rad, min-snap rest to rest". The defaults were chosen by eye so that ours come near those
/// figures.
struct RectangleTiming {
  double wait_s{1.9};          ///< rest after each leg
  double reserve{1.1};         ///< legs take so much longer than their greatest speed and acceleration need
  bool turns_in_place{false};  ///< first of all; else the heading turns along with the first leg
};

/// A rectangle of 3 x 2 m, flown round once from the heading 0 to that of 1.5 rad.
LegPath rectangle(double speed_m_s, double acceleration_m_s2, const RectangleTiming& timing = {});

}  // namespace sortie::bench
