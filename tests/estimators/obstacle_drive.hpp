// SPDX-License-Identifier: BSD-3-Clause
// A body that climbs a step by pure geometry, as steps for the obstacle modes: rear wheel on the floor
// without slip, run on the edge, then tipping about the edge.
#pragma once

#include <cmath>
#include <vector>

#include "estimators/obstacle_modes.hpp"

namespace sortie::estimators::test {

/// A step of the climb, and the height of the body's origin behind it.
struct ClimbStep {
  ObstacleStep step;
  double height_m;
  bool leans;  ///< rear wheel on the floor, run on the edge
};

inline ObstacleStep level_step(double dt_s, double travel_m, double from_rad, double to_rad) {
  ObstacleStep s;
  s.dt_s = dt_s;
  s.travel_m = travel_m;
  s.turn_rad = {0, from_rad - to_rad, 0};
  s.up_begin = {std::sin(from_rad), 0, std::cos(from_rad)};
  s.up_end = {std::sin(to_rad), 0, std::cos(to_rad)};
  return s;
}

/// From the floor over a step of `height_m` to its top. Folded flippers; starts and ends level.
inline std::vector<ClimbStep> climb_step(const TrackProfile& p, double height_m, double speed_m_s,
                                         double dt_s) {
  std::vector<ClimbStep> steps;
  const double each = speed_m_s * dt_s;
  const double r = p.radius_m, a = p.half_length_m;
  bool leans = false;
  const auto put = [&](double travel, double from, double to, double height) {
    steps.push_back({level_step(dt_s, travel, from, to), height, leans});
  };
  for (double x = 0; x < 0.4; x += each) put(each, 0, 0, -p.run_m());
  // The front wheel climbs the edge: its centre turns about it, the rear wheel stays on the floor. The pitch
  // follows from the height of the front wheel's centre.
  const auto rear_height = [&](double t) { return r + a * std::sin(t) - p.axle_m * std::cos(t); };
  const auto way = [&](double t) { return (height_m - r * (1 - std::cos(t))) / std::sin(t); };
  double t = 0;
  double first = std::asin(height_m / (2 * a));
  while (way(first) > 2 * a) first += 1e-4;  // the pitch at which the run comes to lie on the edge
  const double rate = each / (2 * a);        // up the face, the rear wheel stands
  while (t < first) {
    const double next = std::min(first, t + rate);
    put(each, t, next, rear_height(next));
    t = next;
  }
  const auto belt = [&](double x) { return -way(x) * std::cos(x) - r * std::sin(x) + r * x; };
  // Rear wheel on the floor, edge under the run, until the edge is below the centre of mass.
  leans = true;
  while (way(t) - a > balance_on_run_m(p, t)) {
    double low = t, high = t + 0.2;
    for (int i = 0; i < 50; ++i)
      (belt(0.5 * (low + high)) - belt(t) < each ? low : high) = 0.5 * (low + high);
    put(each, t, low, rear_height(low));
    t = low;
  }
  // Tips: about the edge, which moves back with the belt.
  leans = false;
  double s = way(t) - a;
  double z = rear_height(t);
  double fall = 0;
  while (t > 0) {
    fall += 6.0 * dt_s;
    const double next = std::max(0.0, t - fall * dt_s);
    const double half = 0.5 * (t + next);
    s -= each;
    const double turn = next - t;
    z += (each + turn * p.run_m()) * std::sin(half) - turn * s * std::cos(half);
    put(each, t, next, z);
    t = next;
  }
  for (double x = 0; x < 0.4; x += each) put(each, 0, 0, z);
  return steps;
}

}  // namespace sortie::estimators::test
