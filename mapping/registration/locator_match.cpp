// SPDX-License-Identifier: BSD-3-Clause
// A locator's matches: where the odometry says, and where the robot was last.
#include <algorithm>

#include "mapping/registration/locator.hpp"
#include "mapping/registration/pose_algebra.hpp"

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kRays = 128;
constexpr std::uint32_t kMostRaySteps = 64;
}  // namespace

Match Locator::match_to_map(const PosePrior& prior, const OdometryHint& odometry) {
  const RigidPose other = tied_ && odometry.known ? prior.at : newest_;
  // What was told is not what a scan saw: all starts are tried.
  const double usual = anchor_ == Anchor::told ? kNeverUsual : usual_share_;
  Match match = registration_.match(prior.at, other, prior, usual);
  look_along_rays(match);
  if (!clear() && !match.recovered) {  // it looked well, and cannot be
    const std::uint32_t spent = match.steps;
    match = registration_.match(prior.at, other, prior, kNeverUsual);
    match.steps += spent;
    look_along_rays(match);
  }
  return match;
}

/// Whether a scan that does not fit where the odometry has it, too far off for any start there, fits where
/// the robot was last: then `match` is of that place, and the odometry may have jumped. A second match.
bool Locator::found_where_it_was(const RigidPose& told, Match& match) {
  if (!are_apart(told, newest_, config_.recovery_move_m, config_.recovery_turn_rad)) return false;
  const PosePrior prior = going_on();
  const OdometryHint none;
  Match other = registration_.match(prior.at, newest_, prior, usual_share_);
  look_along_rays(other);
  other.steps += match.steps;
  if (judge(other, prior, none) != LocateVerdict::accepted) {
    look_along_rays(match);
    match.steps = other.steps;
    return false;
  }
  match = other;
  return true;
}

void Locator::look_along_rays(const Match& match) {
  const std::uint32_t through =
      rays_through_surfaces(registration_.layer(0), registration_.sample(), match.pose, kRays, kMostRaySteps);
  located_.crossed = through / static_cast<double>(std::min<std::size_t>(kRays, located_.returns));
  located_.inside = seen_.share_inside(registration_.sample(), match.pose);
}

}  // namespace sortie::mapping
