// SPDX-License-Identifier: BSD-3-Clause
// What a pilot takes from somebody outside, and what it refuses.
#pragma once

#include <cmath>
#include <cstdint>

#include "planner/request_gate.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::planner {

/// A goal further off than this is no goal.
inline constexpr double kFarthestGoal_m = 8000.0;

/// Judges requests by content and counter, as RequestGate does those to a drive: where they come in, and once
/// more by the pilot. 32 bytes.
struct FlyGate {
  std::int64_t newest{};  ///< counter of the last request that was taken
  RequestCounters counters;
  SORTIE_FIELDS(newest, counters)

  /// Takes or refuses, and counts. Status: ok, not_finite, out_of_range, time_repeated (the counter does not
  /// rise), malformed (it jumps). A refused request changes nothing, so its counter can be used again.
  Status take(const rt::FlyRequest& request) {
    const Status status = judge(request);
    std::uint32_t& reason = status == Status::ok              ? counters.taken
                            : status == Status::not_finite    ? counters.not_finite
                            : status == Status::time_repeated ? counters.repeated
                            : status == Status::malformed     ? counters.jumped
                                                              : counters.out_of_range;
    ++reason;
    if (status == Status::ok) newest = request.counter;
    return status;
  }

 private:
  Status judge(const rt::FlyRequest& request) const {
    if (request.counter <= newest) return Status::time_repeated;
    if (newest < 0 || request.counter - newest > kMostCounterStep) return Status::malformed;
    for (const double place : request.p_world_m) {
      if (!std::isfinite(place)) return Status::not_finite;
      if (std::fabs(place) > kFarthestGoal_m) return Status::out_of_range;
    }
    if (!std::isfinite(request.yaw_rad)) return Status::not_finite;
    const bool fits =
        std::fabs(request.yaw_rad) <= 7.0 && request.mode <= static_cast<std::uint32_t>(rt::FlyMode::release);
    return fits ? Status::ok : Status::out_of_range;
  }
};

}  // namespace sortie::planner
