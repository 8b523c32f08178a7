// SPDX-License-Identifier: BSD-3-Clause
// What requests to a drive and to a pilot can mean, and which of them stop the robot.
#pragma once

#include <cmath>
#include <cstdint>

#include "rt/samples.hpp"
#include "rt/status.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::planner {

/// Beyond these a request is no request: what a tracked robot cannot mean. Below them the drive's own limits
/// shorten what does not fit.
inline constexpr double kMostAskedSpeed_m_s = 10.0;
inline constexpr double kMostAskedTurn_rad_s = 20.0;
/// A goal further off than this is no goal.
inline constexpr double kFarthestGoal_m = 8000.0;

/// 0: asks for motion, or gives control back. Above 0 it stops, the higher the more final.
constexpr std::uint32_t stop_rank(const rt::DriveRequest& request) {
  switch (static_cast<rt::DriveMode>(request.mode)) {
    case rt::DriveMode::halt:
      return 1;
    case rt::DriveMode::emergency:
      return 2;
    default:
      return 0;
  }
}
constexpr std::uint32_t stop_rank(const rt::FlyRequest& request) {
  switch (static_cast<rt::FlyMode>(request.mode)) {
    case rt::FlyMode::hover:
      return 1;
    case rt::FlyMode::land:
      return 2;
    case rt::FlyMode::stop:
      return 3;
    default:
      return 0;
  }
}

/// True where a stop is right whenever it comes, however old: standing still harms no ground robot. In the
/// air no state is safe for ever, so there a stop must be of now.
constexpr bool stops_at_any_age(const rt::DriveRequest&) { return true; }
constexpr bool stops_at_any_age(const rt::FlyRequest&) { return false; }

/// Status: ok, not_finite, out_of_range. `postures`: how many there are; a pilot has none. Stops are not
/// asked: nothing beside their mode counts.
inline Status check_content(const rt::DriveRequest& request, std::int32_t postures) {
  if (!std::isfinite(request.speed_m_s) || !std::isfinite(request.turn_rad_s)) return Status::not_finite;
  const bool fits = std::fabs(request.speed_m_s) <= kMostAskedSpeed_m_s &&
                    std::fabs(request.turn_rad_s) <= kMostAskedTurn_rad_s &&
                    request.mode <= static_cast<std::uint32_t>(rt::DriveMode::emergency_end) &&
                    request.posture >= -1 && request.posture < postures &&
                    (request.flags & ~std::uint32_t{rt::kDriveThoughTilted | rt::kDriveAnew}) == 0;
  return fits ? Status::ok : Status::out_of_range;
}
inline Status check_content(const rt::FlyRequest& request, std::int32_t) {
  for (const double place : request.p_world_m) {
    if (!std::isfinite(place)) return Status::not_finite;
    if (std::fabs(place) > kFarthestGoal_m) return Status::out_of_range;
  }
  if (!std::isfinite(request.yaw_rad)) return Status::not_finite;
  const bool fits =
      std::fabs(request.yaw_rad) <= 7.0 && request.mode <= static_cast<std::uint32_t>(rt::FlyMode::release);
  return fits ? Status::ok : Status::out_of_range;
}

/// The request without what does not count: of a stop nothing but its mode.
template <class Request>
Request plain(const Request& request) {
  if (stop_rank(request) == 0) return request;
  Request stop;
  stop.stamp_ns = request.stamp_ns;
  stop.counter = request.counter;
  stop.mode = request.mode;
  return stop;
}

}  // namespace sortie::planner
