// SPDX-License-Identifier: BSD-3-Clause
// Ground by a formula for the posture's tests, and a brute-force twin that searches the lowest place of the
// centre of mass with an underside of its own.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "planner/posture.hpp"

namespace sortie::planner {

/// A height everywhere, read as cells that know the height of their middle.
struct FormulaGround {
  std::function<double(double x, double y)> height;
  double cell_m{0.05};

  static HeightCell cell(const void* ground, std::int64_t i, std::int64_t j) {
    const auto& self = *static_cast<const FormulaGround*>(ground);
    const double h = self.height((static_cast<double>(i) + 0.5) * self.cell_m,
                                 (static_cast<double>(j) + 0.5) * self.cell_m);
    return {h, h, HeightState::known};
  }
  HeightView view() const { return {this, &FormulaGround::cell, cell_m}; }
};

/// The underside as a cloud of points, 4 degrees apart on rims and 2 cm along the runs: body axes.
inline std::vector<rt::Vector3> underside_points(const PostureVehicle& v, const FlipperSet& flippers) {
  std::vector<rt::Vector3> points;
  const auto hull = [&](double y, rt::Vector3 a, double ra, rt::Vector3 b, double rb) {
    // The hull of two discs: all discs between them, of which the lower halves are enough.
    for (int k = 0; k <= 20; ++k) {
      const double share = k / 20.0;
      const double r = ra + share * (rb - ra);
      for (int turn = 0; turn <= 180; turn += k == 0 || k == 20 ? 4 : 12) {
        const double angle = -(turn * 3.14159265358979 / 180.0);
        points.push_back({a.x + share * (b.x - a.x) + r * std::cos(angle), y,
                          a.z + share * (b.z - a.z) + r * std::sin(angle)});
      }
    }
  };
  const estimators::TrackProfile& p = v.side;
  for (const double side : {-1.0, 1.0}) {
    for (const double edge : {-0.5, 0.0, 0.5}) {
      const double y = side * p.half_width_m + edge * v.track_width_m;
      hull(y, {-p.half_length_m, y, p.axle_m}, p.radius_m, {p.half_length_m, y, p.axle_m}, p.radius_m);
    }
  }
  for (int f = 0; f < 4; ++f) {
    const double ahead = f < 2 ? 1.0 : -1.0;
    const double side = f % 2 == 0 ? 1.0 : -1.0;
    for (const double edge : {-0.5, 0.5}) {
      const double y = side * v.flipper_y_m + edge * v.flipper_width_m;
      hull(y, {ahead * p.pivot_x_m, y, p.pivot_z_m}, p.pivot_radius_m,
           {ahead * (p.pivot_x_m + p.flipper_m * std::cos(flippers.angle_rad[f])), y,
            p.pivot_z_m + p.flipper_m * std::sin(flippers.angle_rad[f])},
           p.tip_radius_m);
    }
  }
  for (int k = 0; k <= 40; ++k)
    for (int l = -5; l <= 5; ++l)
      points.push_back({v.belly_rear_m + k / 40.0 * (v.belly_front_m - v.belly_rear_m),
                        0.2 * l * v.belly_half_width_m, v.belly_z_m});
  return points;
}

/// Heights of origin and centre of mass of the vehicle let down on `ground` at a tilt, without any cells.
struct LetDown {
  double origin_m{}, com_m{};
};

inline LetDown let_down(const FormulaGround& ground, const std::vector<rt::Vector3>& points,
                        const rt::Vector3& com, const StandPose& pose, double pitch_rad, double roll_rad) {
  const rt::RotationMatrix turn = rt::to_matrix(rt::from_yaw_pitch_roll(pose.yaw_rad, pitch_rad, roll_rad));
  LetDown down{-1e9, 0.0};
  for (const rt::Vector3& point : points) {
    const rt::Vector3 p = turn * point;
    down.origin_m = std::max(down.origin_m, ground.height(pose.x_m + p.x, pose.y_m + p.y) - p.z);
  }
  down.com_m = down.origin_m + (turn * com).z;
  return down;
}

/// Follows the centre of mass down from a tilt, by ever smaller steps, to 0.0002 rad.
inline void descend(const FormulaGround& ground, const std::vector<rt::Vector3>& points,
                    const rt::Vector3& com, const StandPose& pose, double step_rad, double& pitch_rad,
                    double& roll_rad) {
  double best = let_down(ground, points, com, pose, pitch_rad, roll_rad).com_m;
  while (step_rad > 2e-4) {
    bool better = false;
    const double from_pitch = pitch_rad, from_roll = roll_rad;
    for (int k = 0; k < 16; ++k) {
      const double p = from_pitch + step_rad * std::cos(k * 0.39269908);
      const double r = from_roll + step_rad * std::sin(k * 0.39269908);
      const double height = let_down(ground, points, com, pose, p, r).com_m;
      if (height >= best - 1e-12) continue;
      best = height;
      pitch_rad = p;
      roll_rad = r;
      better = true;
    }
    if (!better) step_rad *= 0.5;
  }
}

}  // namespace sortie::planner
