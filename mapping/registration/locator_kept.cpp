// SPDX-License-Identifier: BSD-3-Clause
// What a locator takes from before: a kept map, a word where on it the robot is, and a kept state.
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

void Locator::take_back() {
  if (anchor_ != Anchor::told) return;
  anchor_ = Anchor::unplaced;
  tied_ = false;
  newest_ = before_ = located_.T_map_sensor = located_.T_map_odom = {};
}

void Locator::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "locator")
      .fixed(config_)
      .scratch(left_out_)
      .state(registration_, seen_, located_, anchor_, told_move_m_, told_turn_rad_, tied_, newest_, before_,
             newest_ns_, before_ns_, usual_share_, jumped_);
  if (!archive.is_reading()) return;
  for (const RigidPose& pose :
       {located_.T_map_odom, located_.T_map_sensor, newest_, before_, jumped_.T_map_odom()})
    check_pose(archive, pose);
  constexpr rt::Nanoseconds kFar = rt::Nanoseconds{1} << 61;  // differences of such stamps do not overflow
  for (const rt::Nanoseconds stamp : {located_.stamp_ns, newest_ns_, before_ns_}) {
    if (stamp < -kFar || stamp > kFar) archive.fail(Status::malformed, "a stamp that is none");
  }
  if (anchor_ > Anchor::held) archive.fail(Status::malformed, "a map that hangs on nothing");
  if (!std::isfinite(usual_share_) || !std::isfinite(told_move_m_) || !std::isfinite(told_turn_rad_))
    archive.fail(Status::malformed, "a number that is not finite");
  if (located_.weak_moves > 3 || located_.weak_turns > 3 || located_.verdict > LocateVerdict::unplaced)
    archive.fail(Status::malformed, "a place that is none");
}

}  // namespace sortie::mapping
