// SPDX-License-Identifier: BSD-3-Clause
// What the tracked robot stands on and runs into: a plane through the ground below it, and its outline.
#include <algorithm>
#include <cmath>

#include "hil/kinematic_robot.hpp"

namespace sortie::hil {
namespace {

constexpr int kSamplesPerTrack = 9;

}  // namespace

KinematicRobot::Ground KinematicRobot::ground_at(double x_m, double y_m, double yaw_rad) const {
  const auto [s, c] = rt::sincos(yaw_rad);
  const double half_track = 0.5 * config_.track_distance_m;
  double heights[2][kSamplesPerTrack];
  double along[kSamplesPerTrack];
  double sums[2] = {0.0, 0.0};
  double moment = 0.0;
  double spread = 0.0;
  for (int i = 0; i < kSamplesPerTrack; ++i) {
    along[i] =
        config_.contact_length_m * (static_cast<double>(i) / static_cast<double>(kSamplesPerTrack - 1) - 0.5);
    for (int side = 0; side < 2; ++side) {
      const double across = side == 0 ? half_track : -half_track;
      const double h =
          world_->terrain_height(x_m + c * along[i] - s * across, y_m + s * along[i] + c * across);
      heights[side][i] = h;
      sums[side] += h;
      moment += along[i] * h;
    }
    spread += 2.0 * along[i] * along[i];
  }
  // Least-squares plane height = mean + slope_x * x + slope_y * y in the frame turned by the yaw alone.
  constexpr double kPerTrack = kSamplesPerTrack;
  const double mean = (sums[0] + sums[1]) / (2.0 * kPerTrack);
  const double slope_x = moment / spread;
  const double slope_y = (sums[0] - sums[1]) / (kPerTrack * config_.track_distance_m);
  double roughness = 0.0;
  for (int i = 0; i < kSamplesPerTrack; ++i) {
    const double left = mean + slope_x * along[i] + slope_y * half_track;
    const double right = mean + slope_x * along[i] - slope_y * half_track;
    roughness = std::max({roughness, std::fabs(heights[0][i] - left), std::fabs(heights[1][i] - right)});
  }
  const double pitch = -rt::atan2(slope_x, 1.0);
  const double roll = rt::atan2(slope_y * rt::cos(pitch), 1.0);
  return {mean, pitch, roll, roughness};
}

bool KinematicRobot::obstructed(double x_m, double y_m, double yaw_rad, double height_m) const {
  const auto [s, c] = rt::sincos(yaw_rad);
  return world_->blocked({.center_x_m = x_m,
                          .center_y_m = y_m,
                          .cos_yaw = c,
                          .sin_yaw = s,
                          .half_x_m = 0.5 * config_.outline_length_m,
                          .half_y_m = 0.5 * config_.outline_width_m,
                          .bottom_m = height_m + config_.clearance_m,
                          .top_m = height_m + config_.outline_height_m});
}

}  // namespace sortie::hil
