// SPDX-License-Identifier: BSD-3-Clause
// Paths in time that benchmarks fly.
#include "tests/bench/uav/legs.hpp"

#include <algorithm>

namespace sortie::bench {
namespace {

constexpr double kTurn_rad_s = 1.64;  // greatest rate of the heading: 1.5 rad take two seconds

}  // namespace

LegPath::LegPath(std::vector<Corner> corners, double speed_m_s, double acceleration_m_s2, double wait_s,
                 double reserve)
    : corners_(std::move(corners)) {
  double time_s = 0.0;
  for (std::size_t i = 0; i + 1 < corners_.size(); ++i) {
    const double way_m = rt::norm(corners_[i + 1].p_m - corners_[i].p_m);
    // Of s(x) = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7 the greatest slope is 35/16, the greatest curvature 7.5132.
    const double turn_s =
        35.0 / 16.0 * std::fabs(corners_[i + 1].yaw_rad - corners_[i].yaw_rad) / kTurn_rad_s;
    const double leg_s = reserve * std::max({35.0 / 16.0 * way_m / speed_m_s,
                                             std::sqrt(7.5132 * way_m / acceleration_m_s2), turn_s, 1e-3});
    start_s_.push_back(time_s);
    leg_s_.push_back(leg_s);
    time_s += leg_s + wait_s;
  }
  end_s_ = time_s;
}

planner::FlatReference LegPath::at(double time_s) const {
  planner::FlatReference r;
  r.p_m = corners_.front().p_m;
  r.yaw_rad = corners_.front().yaw_rad;
  std::size_t leg = 0;
  while (leg < start_s_.size() && time_s >= start_s_[leg]) ++leg;
  if (leg == 0) return r;
  --leg;
  const double t = leg_s_[leg];
  const double x = std::clamp((time_s - start_s_[leg]) / t, 0.0, 1.0);
  const double x2 = x * x;
  const double x3 = x2 * x;
  const double s0 = x3 * x * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)));
  const double s1 = x3 * (140.0 + x * (-420.0 + x * (420.0 - 140.0 * x))) / t;
  const double s2 = x2 * (420.0 + x * (-1680.0 + x * (2100.0 - 840.0 * x))) / (t * t);
  const double s3 = x * (840.0 + x * (-5040.0 + x * (8400.0 - 4200.0 * x))) / (t * t * t);
  const double s4 = (840.0 + x * (-10080.0 + x * (25200.0 - 16800.0 * x))) / (t * t * t * t);
  const Corner& from = corners_[leg];
  const rt::Vector3 way = corners_[leg + 1].p_m - from.p_m;
  const double turn = corners_[leg + 1].yaw_rad - from.yaw_rad;
  r.p_m = from.p_m + s0 * way;
  r.v_m_s = s1 * way;
  r.a_m_s2 = s2 * way;
  r.j_m_s3 = s3 * way;
  r.s_m_s4 = x < 1.0 ? s4 * way : rt::Vector3{};
  r.yaw_rad = from.yaw_rad + s0 * turn;
  r.yaw_rate_rad_s = s1 * turn;
  r.yaw_acceleration_rad_s2 = s2 * turn;
  return r;
}

LegPath rectangle(double speed_m_s, double acceleration_m_s2, const RectangleTiming& timing) {
  constexpr double kYaw = 1.5;
  std::vector<LegPath::Corner> corners{{{0, 0, 1}, 0.0}};
  if (timing.turns_in_place) corners.push_back({{0, 0, 1}, kYaw});
  for (const rt::Vector3& corner : {rt::Vector3{3, 0, 1}, {3, 2, 1}, {0, 2, 1}, {0, 0, 1}})
    corners.push_back({corner, kYaw});
  return LegPath(std::move(corners), speed_m_s, acceleration_m_s2, timing.wait_s, timing.reserve);
}

}  // namespace sortie::bench
