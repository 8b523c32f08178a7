// SPDX-License-Identifier: BSD-3-Clause
// The waypoint follower: what it wishes for, and how it gets free.
#include "planner/waypoint_follower.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner {
namespace {
constexpr double kFarthest_m = 1e6;
constexpr double kHalfTurn_rad = 3.14159265358979323846;
constexpr double kMargin = 0.8;  // braking is planned with this share of the limit

double distance(double dx, double dy) { return std::sqrt(dx * dx + dy * dy); }

/// The speed from which the robot slows down to `end` within `way`, braking with `ramp`. With a constant
/// deceleration a that takes a / j to build up, v^2 / 2a + v a / 2j = way + (the same of the end speed).
double braking_speed(double way_m, double end_m_s, const RampLimits& ramp) {
  const double a = kMargin * ramp.acceleration;
  const double lead = 0.5 * a * a / ramp.jerk;  // speed that is lost while the brake builds up
  const double square = lead * lead + 2.0 * a * way_m + end_m_s * (end_m_s + 2.0 * lead);
  return std::sqrt(square) - lead;
}
}  // namespace

Status WaypointFollower::set_route(std::span<const Waypoint> route) {
  if (route.size() > kMaxWaypoints) return Status::full;
  for (const Waypoint& w : route) {
    if (!std::isfinite(w.x_m) || !std::isfinite(w.y_m)) return Status::not_finite;
    if (std::fabs(w.x_m) > kFarthest_m || std::fabs(w.y_m) > kFarthest_m) return Status::out_of_range;
  }
  std::copy(route.begin(), route.end(), route_.begin());
  size_ = static_cast<std::uint32_t>(route.size());
  next_ = 0;
  leg_ = ~0u;
  turning_ = reverse_ = false;
  encourage();
  return Status::ok;
}

void WaypointFollower::encourage() {
  phase_ = Phase::following;
  tries_ = 0;
  watching_ = false;
}

SpeedTurn WaypointFollower::wish(const rt::PoseEstimate& pose, const TwistLimits& limits,
                                 const TwistRamps& ramps, rt::Nanoseconds now_ns) {
  const double x_m = pose.p_world_body_m[0];
  const double y_m = pose.p_world_body_m[1];
  advance_route(x_m, y_m);
  if (done()) {
    turning_ = reverse_ = false;
    phase_ = Phase::following;
    return {};
  }
  if (phase_ != Phase::following) {
    const SpeedTurn way_out = get_free(x_m, y_m, limits, now_ns);
    if (phase_ != Phase::following) return way_out;
  }
  const double dx = route_[next_].x_m - x_m;
  const double dy = route_[next_].y_m - y_m;
  const double to_go = distance(dx, dy);
  const double heading = rt::yaw_of(rt::to_quaternion(pose.q_world_body));
  double error = rt::wrap_angle(rt::atan2(dy, dx) - heading);
  if (leg_ != next_) begin_leg(to_go, error);
  if (reverse_) error = rt::wrap_angle(error + kHalfTurn_rad);
  turning_ = std::fabs(error) > (turning_ ? config_.spot_turn_end_rad : config_.spot_turn_begin_rad);
  if (is_stuck(to_go, std::fabs(error), now_ns)) {
    ++counters_.stuck;
    phase_ = tries_ >= config_.stuck_tries ? Phase::given_up : Phase::resting;
    since_ns_ = now_ns;
    return {};
  }
  const double turn =
      std::clamp(config_.heading_gain_per_s * error, -limits.max_turn_rad_s, limits.max_turn_rad_s);
  if (turning_) return {0.0, turn};
  // Slows down up to the middle of the circle within which the waypoint counts as reached.
  const double way = std::max(0.0, to_go - 0.5 * config_.reach_radius_m);
  const double braking = braking_speed(way, speed_at_waypoint(limits.max_speed_m_s), ramps.speed);
  const double speed = std::min(limits.max_speed_m_s, std::max(config_.creep_speed_m_s, braking)) *
                       std::max(0.0, rt::cos(error));
  return {reverse_ ? -speed : speed, turn};
}

/// Goes on to the first waypoint that is not yet reached; at most once around the route.
void WaypointFollower::advance_route(double x_m, double y_m) {
  for (std::uint32_t i = 0; i < size_ && next_ < size_; ++i) {
    if (distance(route_[next_].x_m - x_m, route_[next_].y_m - y_m) > config_.reach_radius_m) return;
    ++counters_.reached;
    ++next_;
    if (config_.repeat && next_ >= size_) next_ = 0;
    leg_ = ~0u;
    encourage();
  }
}

/// Speed that the corner after the next waypoint allows: full for straight on, none where the robot must turn
/// on the spot or drive the other way.
double WaypointFollower::speed_at_waypoint(double max_speed_m_s) const {
  if (next_ + 1 >= size_ || next_ == 0 || config_.reverse_m > 0.0) return 0.0;
  const Waypoint& before = route_[next_ - 1];
  const Waypoint& corner = route_[next_];
  const Waypoint& after = route_[next_ + 1];
  const double in = rt::atan2(corner.y_m - before.y_m, corner.x_m - before.x_m);
  const double out = rt::atan2(after.y_m - corner.y_m, after.x_m - corner.x_m);
  const double turn = std::fabs(rt::wrap_angle(out - in));
  return max_speed_m_s * std::max(0.0, 1.0 - turn / config_.spot_turn_begin_rad);
}

/// Forward or reverse is decided once for each waypoint.
void WaypointFollower::begin_leg(double distance_m, double heading_error_rad) {
  leg_ = next_;
  reverse_ = distance_m <= config_.reverse_m && std::fabs(heading_error_rad) > 0.5 * kHalfTurn_rad;
  turning_ = false;
  watching_ = false;
}

/// Progress is a shorter way or a smaller heading error than ever on this leg, by more than a little.
bool WaypointFollower::is_stuck(double distance_m, double heading_error_rad, rt::Nanoseconds now_ns) {
  const bool nearer = distance_m <= best_m_ - config_.stuck_progress_m;
  const bool turned = heading_error_rad <= best_rad_ - config_.stuck_progress_rad;
  if (!watching_ || nearer || turned) {
    if (!watching_ || nearer) best_m_ = distance_m;
    if (!watching_ || turned) best_rad_ = heading_error_rad;
    watching_ = true;
    since_ns_ = now_ns;
  }
  return config_.stuck_s > 0.0 && rt::to_seconds(now_ns - since_ns_) > config_.stuck_s;
}

/// Stands, then drives back the way it came, then tries again. Also gives up driving back when that does not
/// move the robot either.
SpeedTurn WaypointFollower::get_free(double x_m, double y_m, const TwistLimits& limits,
                                     rt::Nanoseconds now_ns) {
  const double in_phase_s = rt::to_seconds(now_ns - since_ns_);
  if (phase_ == Phase::resting && in_phase_s >= config_.stuck_pause_s) {
    ++tries_;
    ++counters_.backed_off;
    phase_ = Phase::backing;
    since_ns_ = now_ns;
    from_x_m_ = x_m;
    from_y_m_ = y_m;
  } else if (phase_ == Phase::backing && (distance(x_m - from_x_m_, y_m - from_y_m_) >= config_.back_off_m ||
                                          in_phase_s > config_.stuck_s)) {
    phase_ = Phase::following;
    watching_ = false;
  }
  if (phase_ != Phase::backing) return {};
  const double speed = std::min(limits.max_speed_m_s, 3.0 * config_.creep_speed_m_s);
  return {reverse_ ? speed : -speed, 0.0};
}

void WaypointFollower::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "waypoint follower")
      .fixed(config_)
      .by_hand(size_, next_, phase_)
      .state(route_, leg_, tries_, turning_, reverse_, watching_, since_ns_, best_m_, best_rad_, from_x_m_,
             from_y_m_, counters_);
  archive.bounded(size_, kMaxWaypoints);
  archive.bounded(next_, size_);
  auto phase = static_cast<std::uint32_t>(phase_);
  archive.bounded(phase, static_cast<std::uint32_t>(Phase::given_up));
  phase_ = static_cast<Phase>(phase);
}

}  // namespace sortie::planner
