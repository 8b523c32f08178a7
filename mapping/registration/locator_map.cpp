// SPDX-License-Identifier: BSD-3-Clause
// A locator on a kept map: taking the map, and being told where on it the robot is.
#include <cmath>

#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/locator.hpp"

namespace sortie::mapping {
namespace {

/// Of all directions at once, from the covariance's trace; above 0 where it is one.
double sigma_of(const double (&covariance)[36], int at) {
  double sum = 0.0;
  for (int i = at; i < at + 3; ++i) sum += covariance[7 * i];
  return std::sqrt(sum);
}

bool is_sigma(double sigma) { return sigma > 1e-9 && sigma < 1e9; }

}  // namespace

SurfelMapResult Locator::load(std::span<const std::uint8_t> map) {
  const SurfelMapResult result = load_surfel_map(map, registration_);
  anchor_ = result.fault == SurfelMapFault::none ? Anchor::unplaced : Anchor::none;
  return result;
}

Status Locator::place(const RigidPose& T_map_sensor, const double (&covariance)[36],
                      const OdometryHint& odometry) {
  if (anchor_ != Anchor::unplaced && anchor_ != Anchor::told) return Status::not_supported;
  if (!rt::is_finite(T_map_sensor.p) || !rt::is_finite(T_map_sensor.q)) return Status::not_finite;
  const double move_m = sigma_of(covariance, 0);
  const double turn_rad = sigma_of(covariance, 3);
  if (!is_pose(T_map_sensor) || !is_sigma(move_m) || !is_sigma(turn_rad)) return Status::out_of_range;
  if (odometry.known && !is_pose(odometry.T_odom_sensor)) return Status::out_of_range;
  const RigidPose pose{T_map_sensor.p, rt::normalised(T_map_sensor.q)};
  anchor_ = Anchor::told;
  told_move_m_ = move_m;
  told_turn_rad_ = turn_rad;
  newest_ = before_ = located_.T_map_sensor = pose;
  if (config_.planar) newest_ = before_ = laid_flat(pose);
  tied_ = odometry.known;
  if (!tied_) return Status::ok;
  const RigidPose odom = config_.planar ? laid_flat(odometry.T_odom_sensor) : odometry.T_odom_sensor;
  located_.T_map_odom.q = rt::normalised(newest_.q * rt::conjugate(odom.q));
  located_.T_map_odom.p = newest_.p - rt::rotate(located_.T_map_odom.q, odom.p);
  return Status::ok;
}

}  // namespace sortie::mapping
