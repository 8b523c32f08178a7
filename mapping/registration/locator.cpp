// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/locator.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/match_covariance.hpp"
#include "mapping/registration/pose_algebra.hpp"

namespace sortie::mapping {
namespace {
constexpr std::size_t kLeastReturns = 100;
constexpr std::size_t kLeastReturnsInPlane = 40;  ///< of one row: a wall 1 m off fills half of what it sees
constexpr double kFastMargin = 2.0;               ///< what holds a direction, against noise, without odometry
constexpr double kFastMarginInPlane = 7.0;        ///< there a cell needs no neighbour to hold
constexpr double kFar2 = 22.46;                   ///< 99.9 % of chi-square with 6 degrees of freedom
constexpr double kFarInPlane2 = 16.27;            ///< with 3

/// `share` of a motion goes on.
RigidPose gone_on(const RigidPose& from, const RigidPose& to, double share) {
  const RigidPose step = after(inverse(from), to);
  return after(to, {share * step.p, rt::exp_rotation(share * rt::log_rotation(step.q))});
}

/// Numbers that a pose can be made of: others would stay in the map's place for good.
bool usable(const OdometryHint& hint) {
  const double q2 = rt::squared_norm(hint.T_odom_sensor.q);
  const auto fits = [](double sigma) { return sigma > 1e-9 && sigma < 1e9; };
  return hint.known && rt::is_finite(hint.T_odom_sensor.p) && q2 > 0.99 && q2 < 1.01 &&
         fits(hint.sigma_move_m) && fits(hint.sigma_turn_rad);
}

void set_information(PosePrior& prior, double sigma_turn_rad, double sigma_move_m) {
  for (int i = 0; i < 3; ++i) {
    prior.information[i][i] = 1.0 / (sigma_turn_rad * sigma_turn_rad);
    prior.information[3 + i][3 + i] = 1.0 / (sigma_move_m * sigma_move_m);
  }
}

/// Standard deviation of a sum.
double both(double a, double b) { return std::sqrt(a * a + b * b); }

/// Every direction is held by far more than noise could make of nothing.
bool held_fast(const NormalEquations& equations) {
  const WeakDirections weak = weak_directions(equations, equations.planar ? kFastMarginInPlane : kFastMargin);
  return weak.moves + weak.turns == 0;
}

/// Squared distance from the prior in its own standard deviations.
double squared_distance(const PosePrior& prior, const RigidPose& pose) {
  const rt::Vector3 turned = rt::log_rotation(pose.q * rt::conjugate(prior.at.q));
  const rt::Vector3 moved = pose.p - prior.at.p;
  const double x[6] = {turned.x, turned.y, turned.z, moved.x, moved.y, moved.z};
  double sum = 0.0;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) sum += x[i] * prior.information[i][k] * x[k];
  }
  return sum;
}
}  // namespace

const char* to_string(LocateVerdict verdict) {
  constexpr const char* kNames[] = {"none",         "first",     "accepted",  "few returns",
                                    "little share", "crossed",   "ambiguous", "far from prior",
                                    "unheld",       "new place", "unplaced"};
  const auto at = static_cast<std::size_t>(verdict);
  return at < std::size(kNames) ? kNames[at] : "unknown";
}

const Located& Locator::locate(const rt::PointScan& scan, const OdometryHint& hint) {
  OdometryHint odometry = hint;
  odometry.known = usable(hint);
  if (!config_.planar) return look(scan, odometry);
  left_out_ = out_of_plane(odometry.known ? odometry.T_odom_sensor : located_.T_map_sensor);
  odometry.T_odom_sensor = laid_flat(odometry.T_odom_sensor);
  look(scan, odometry);
  located_.T_map_sensor = stood_up(laid_flat(located_.T_map_sensor), left_out_);
  return located_;
}

const Located& Locator::look(const rt::PointScan& scan, const OdometryHint& odometry) {
  const std::span<const rt::ScanPoint> points{scan.points, scan.header.points};
  located_.stamp_ns = scan.header.stamp_ns;
  ++located_.counts.in;
  located_.steps = 0;
  located_.share = located_.known = located_.crossed = located_.inside = 0.0;
  located_.returns = static_cast<std::uint32_t>(registration_.take(points));
  if (config_.planar) registration_.lay_flat(left_out_.tilt);
  located_.weak_moves = located_.weak_turns = 0;
  const PosePrior prior = expect(odometry);
  double covariance[6][6]{};
  if (has_map()) {
    for (int i = 0; i < 6; ++i) covariance[i][i] = 1.0 / prior.information[i][i];  // it is diagonal
  }
  const bool unplaced = anchor_ == Anchor::unplaced;
  if (unplaced || located_.returns < (config_.planar ? kLeastReturnsInPlane : kLeastReturns)) {
    describe({}, covariance, prior.at.q);
    return refuse(unplaced ? LocateVerdict::unplaced : LocateVerdict::few_returns, odometry);
  }
  if (!has_map()) {
    accept(odometry.known ? odometry.T_odom_sensor : RigidPose{}, odometry);
    conclude(LocateVerdict::first);
    return located_;
  }
  Match match = match_to_map(prior, odometry);
  LocateVerdict verdict = judge(match, prior, odometry);
  const bool elsewhere = anchor_ == Anchor::held && tied_ && odometry.known &&
                         (verdict == LocateVerdict::far_from_prior ||
                          (verdict != LocateVerdict::accepted && found_where_it_was(prior.at, match)));
  const bool jumped = elsewhere && jumped_.agrees(match.pose, odometry.T_odom_sensor);
  if (elsewhere) verdict = jumped ? LocateVerdict::accepted : LocateVerdict::far_from_prior;
  located_.share = match.score.matched;
  located_.known = match.score.known;
  located_.steps = match.steps;
  const bool accepted =
      verdict == LocateVerdict::accepted &&
      match_covariance(match.equations, match.weak, jumped ? going_on() : prior, match.spread, covariance);
  if (verdict == LocateVerdict::accepted && !accepted) verdict = LocateVerdict::unheld;
  describe(match.weak, covariance, accepted ? match.pose.q : prior.at.q);
  if (!accepted && verdict != LocateVerdict::new_place) return refuse(verdict, odometry);
  accept(accepted ? match.pose : prior.at, odometry);
  if (accepted) {
    usual_share_ = match.score.matched;
    jumped_.clear();
    if (match.other_start || jumped) ++located_.counts.recovered;
  }
  conclude(verdict);
  return located_;
}

bool Locator::clear() const {
  return located_.crossed <= config_.most_crossed && located_.inside <= config_.most_inside;
}

/// The odometry's pose or, without any that the map knows, the last motion for as long again.
PosePrior Locator::expect(const OdometryHint& odometry) const {
  PosePrior prior;
  if (tied_ && odometry.known) {
    prior.at = after(located_.T_map_odom, odometry.T_odom_sensor);
    set_information(prior, odometry.sigma_turn_rad, odometry.sigma_move_m);
    if (anchor_ == Anchor::told)
      set_information(prior, both(odometry.sigma_turn_rad, told_turn_rad_),
                      both(odometry.sigma_move_m, told_move_m_));
    return prior;
  }
  if (!has_begun()) {
    prior.at = newest_;
    set_information(prior, 10.0, 10.0);
    return prior;
  }
  return going_on();
}

/// The last motion for as long again; nothing is known of it.
PosePrior Locator::going_on() const {
  PosePrior prior;
  const auto last = static_cast<double>(newest_ns_ - before_ns_);
  const auto now = static_cast<double>(located_.stamp_ns - newest_ns_);
  prior.at = gone_on(before_, newest_, last > 0.0 && now > 0.0 ? std::min(now / last, kLongestGap) : 0.0);
  set_information(prior, 10.0, 10.0);
  return prior;
}

LocateVerdict Locator::judge(const Match& match, const PosePrior& prior, const OdometryHint& odometry) const {
  // A kept map grows only by what was found on it.
  if (anchor_ == Anchor::held && tied_ && odometry.known && match.score.known < config_.least_known &&
      usual_share_ < kYoung && clear())
    return LocateVerdict::new_place;
  // Without odometry nothing else holds what the scan does not, and standing still fits as well as any
  // motion.
  const bool alone = !(tied_ && odometry.known);
  if (match.equations.rows < 6 || (alone && !held_fast(match.equations))) return LocateVerdict::unheld;
  // Since a scan was refused it may have gone farther than any start reaches.
  if (alone && anchor_ == Anchor::held && !is_placed(located_.verdict) &&
      match.score.matched < kLeastAfterRefused)
    return LocateVerdict::little_share;
  if (match.score.matched < config_.least_share * match.score.known ||
      match.score.known < (match.other_start ? kLeastElsewhere : config_.least_known) ||
      match.score.matched < kLeastOfUsual * usual_share_)
    return LocateVerdict::little_share;
  if (!clear() || (alone && located_.inside > kHardlyAny)) return LocateVerdict::crossed;
  if (match.ambiguous) return LocateVerdict::ambiguous;
  if (tied_ && odometry.known &&
      squared_distance(prior, match.pose) > (config_.planar ? kFarInPlane2 : kFar2))
    return LocateVerdict::far_from_prior;
  return LocateVerdict::accepted;
}

void Locator::conclude(LocateVerdict verdict) {
  std::size_t at = 0;
  LocateCounts::fields(located_.counts, [&](const char*, std::uint64_t& count) {
    if (at++ == static_cast<std::size_t>(verdict)) ++count;
  });
  located_.verdict = verdict;
}

const Located& Locator::refuse(LocateVerdict verdict, const OdometryHint& odometry) {
  usual_share_ *= kForget;
  conclude(verdict);
  if (tied_ && odometry.known) located_.T_map_sensor = after(located_.T_map_odom, odometry.T_odom_sensor);
  return located_;
}

void Locator::accept(const RigidPose& pose, const OdometryHint& odometry) {
  located_.T_map_sensor = pose;
  if (odometry.known) {
    located_.T_map_odom = after(pose, inverse(odometry.T_odom_sensor));
    tied_ = true;
  }
  const bool begins = anchor_ != Anchor::held;  // then no motion is known
  anchor_ = Anchor::held;
  before_ = begins ? pose : newest_;
  before_ns_ = begins ? located_.stamp_ns : newest_ns_;
  newest_ = pose;
  newest_ns_ = located_.stamp_ns;
  registration_.insert(pose);
  seen_.take(registration_.chosen(), pose);
}

/// `c`: of (turn, move) along the map's axes; `q_map_sensor` of the pose that it is about.
void Locator::describe(const WeakDirections& weak, const double (&c)[6][6],
                       const rt::Quaternion& q_map_sensor) {
  located_.weak_moves = weak.moves;
  located_.weak_turns = weak.turns;
  const auto note = [&c](const rt::Vector3& axis, int at, WeakDirection& out) {
    const double v[3] = {axis.x, axis.y, axis.z};
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
      out.axis_map[i] = v[i];
      for (int k = 0; k < 3; ++k) sum += v[i] * c[at + i][at + k] * v[k];
    }
    out.sigma = std::sqrt(std::max(0.0, sum));
  };
  for (std::uint32_t i = 0; i < weak.moves; ++i) note(weak.move[i], 3, located_.weak_move[i]);
  for (std::uint32_t i = 0; i < weak.turns; ++i) note(weak.turn[i], 0, located_.weak_turn[i]);
  pose_covariance(c, config_.planar ? q_map_sensor * left_out_.tilt : q_map_sensor, located_.covariance);
}

}  // namespace sortie::mapping
