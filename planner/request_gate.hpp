// SPDX-License-Identifier: BSD-3-Clause
// What the drive takes from somebody outside, and what it refuses.
#pragma once

#include <cmath>
#include <cstdint>

#include "rt/describe.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// Beyond these a request is no request: what a tracked robot cannot mean. Below them the drive's own limits
/// shorten what does not fit.
inline constexpr double kMostAskedSpeed_m_s = 10.0;
inline constexpr double kMostAskedTurn_rad_s = 20.0;
/// A counter further ahead of the newest one is damaged, or meant to shut everybody else out.
inline constexpr std::int64_t kMostCounterStep = 1'000'000;

/// What became of requests, since start.
struct RequestCounters {
  std::uint32_t taken{};
  std::uint32_t not_finite{};
  std::uint32_t out_of_range{};  ///< speed, turn rate, mode, posture or flags that nobody can mean
  std::uint32_t repeated{};      ///< counter not above the newest: played again, or overtaken
  std::uint32_t jumped{};        ///< counter too far above the newest
  SORTIE_FIELDS(taken, not_finite, out_of_range, repeated, jumped)
};

/// Judges requests by content and counter. Used twice: where they come in, so that what is refused is in no
/// log, and by the drive itself, which trusts nobody. 32 bytes.
struct RequestGate {
  std::int64_t newest{};  ///< counter of the last request that was taken
  RequestCounters counters;
  SORTIE_FIELDS(newest, counters)

  /// Takes or refuses, and counts. `postures`: how many there are. Status: ok, not_finite, out_of_range,
  /// time_repeated (the counter does not rise), malformed (it jumps). A refused request changes nothing, so
  /// its counter can be used again.
  Status take(const rt::DriveRequest& request, std::int32_t postures) {
    const Status status = judge(request, postures);
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
  Status judge(const rt::DriveRequest& request, std::int32_t postures) const {
    if (request.counter <= newest) return Status::time_repeated;
    if (newest < 0 || request.counter - newest > kMostCounterStep) return Status::malformed;
    if (!std::isfinite(request.speed_m_s) || !std::isfinite(request.turn_rad_s)) return Status::not_finite;
    const bool fits = std::fabs(request.speed_m_s) <= kMostAskedSpeed_m_s &&
                      std::fabs(request.turn_rad_s) <= kMostAskedTurn_rad_s &&
                      request.mode <= static_cast<std::uint32_t>(rt::DriveMode::halt) &&
                      request.posture >= -1 && request.posture < postures &&
                      (request.flags & ~std::uint32_t{rt::kDriveThoughTilted}) == 0;
    return fits ? Status::ok : Status::out_of_range;
  }
};

}  // namespace sortie::planner
