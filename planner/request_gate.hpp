// SPDX-License-Identifier: BSD-3-Clause
// What a drive or a pilot takes from somebody outside, and what it refuses: order, age, content.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "rt/describe.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"
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
  const auto mode = static_cast<rt::DriveMode>(request.mode);
  return mode == rt::DriveMode::halt ? 1 : mode == rt::DriveMode::emergency ? 2 : 0;
}
constexpr std::uint32_t stop_rank(const rt::FlyRequest& request) {
  const auto mode = static_cast<rt::FlyMode>(request.mode);
  if (mode == rt::FlyMode::hover) return 1;
  if (mode == rt::FlyMode::land) return 2;
  return mode == rt::FlyMode::stop ? 3 : 0;
}

/// True where a stop is right whenever it comes, however old: standing still harms no ground robot. In the
/// air no state is safe for ever, so there a stop must be of now.
constexpr bool stops_at_any_age(const rt::DriveRequest&) { return true; }
constexpr bool stops_at_any_age(const rt::FlyRequest&) { return false; }

/// What one robot allows.
struct RequestRules {
  std::int32_t postures{};         ///< of the flippers, that a request may ask for
  rt::Nanoseconds most_wait_ns{};  ///< from receipt until it is taken; 0: not judged
  bool finds_ways{};               ///< it can be told a place to go to

  bool is_too_old(rt::Nanoseconds stamp_ns, rt::Nanoseconds now_ns) const {
    return most_wait_ns != 0 && now_ns - stamp_ns > most_wait_ns;
  }
};

/// Status: ok, not_finite, out_of_range, or not_supported: it finds no ways of its own. Stops are not asked:
/// nothing beside their mode counts.
inline Status check_content(const rt::DriveRequest& request, const RequestRules& rules) {
  for (const double value : {request.speed_m_s, request.turn_rad_s, request.goal_x_m, request.goal_y_m})
    if (!std::isfinite(value)) return Status::not_finite;
  const bool fits = std::fabs(request.speed_m_s) <= kMostAskedSpeed_m_s &&
                    std::fabs(request.turn_rad_s) <= kMostAskedTurn_rad_s &&
                    request.mode <= static_cast<std::uint32_t>(rt::DriveMode::go) && request.posture >= -1 &&
                    request.posture < rules.postures && std::fabs(request.goal_x_m) <= kFarthestGoal_m &&
                    std::fabs(request.goal_y_m) <= kFarthestGoal_m &&
                    (request.flags & ~std::uint32_t{rt::kDriveThoughTilted | rt::kDriveAnew}) == 0;
  if (!fits) return Status::out_of_range;
  const bool is_go = request.mode == static_cast<std::uint32_t>(rt::DriveMode::go);
  return is_go && !rules.finds_ways ? Status::not_supported : Status::ok;
}
inline Status check_content(const rt::FlyRequest& request, const RequestRules&) {
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

/// A counter further ahead of the newest one is damaged, or meant to shut everybody else out.
inline constexpr std::int64_t kMostCounterStep = 1'000'000;

/// What became of requests, since start.
struct RequestCounters {
  std::uint32_t taken{};
  std::uint32_t not_finite{};
  std::uint32_t out_of_range{};  ///< speed, place, mode, posture or flags that nobody can mean
  std::uint32_t repeated{};      ///< counter not above the newest: played again, or overtaken
  std::uint32_t jumped{};        ///< counter too far above the newest
  std::uint32_t held_back{};     ///< too old when it was to be taken: the process did not run, or was late
  SORTIE_FIELDS(taken, not_finite, out_of_range, repeated, jumped, held_back)
};

/// The counter of a refusal's reason; what has none of its own is out of range.
template <class Counters>
auto& refusal(Counters& counters, Status status) {
  return status == Status::not_finite      ? counters.not_finite
         : status == Status::time_repeated ? counters.repeated
         : status == Status::malformed     ? counters.jumped
         : status == Status::stale         ? counters.held_back
                                           : counters.out_of_range;
}

/// Whether a stop needs its counter.
enum class StopOrder : std::uint8_t {
  any,     ///< taken out of turn: somebody vouches that it is of now, or standing still is always right
  rising,  ///< as every other request
};

/// Judges requests by order, age and content. Used twice: where they come in, so that what is refused is in
/// no log, and by whoever obeys, who trusts nobody.
///
/// The rule for stops, here and wherever one passes: nothing that another sender does may cost a stop. So a
/// stop needs no rising counter (unless a more final one was the last that was taken), has no age once it is
/// in, and nothing it carries beside its mode is looked at. Played again it stops again; it releases nothing.
struct RequestGate {
  std::int64_t newest{};  ///< highest counter that was taken
  std::uint32_t rank{};   ///< stop_rank() of the last request that was taken
  RequestCounters counters;
  SORTIE_FIELDS(newest, rank, counters)

  /// Takes or refuses, and counts. Status: ok, not_finite, out_of_range, time_repeated (the counter does not
  /// rise), malformed (it jumps), stale (it waited too long before `now_ns`). A refused request changes
  /// nothing, so its counter can be used again. A stop out of order leaves `newest` as it is.
  template <class Request>
  Status take(const Request& request, const RequestRules& rules, rt::Nanoseconds now_ns,
              StopOrder order = StopOrder::any) {
    const Status status = judge(request, rules, now_ns, order);
    ++(status == Status::ok ? counters.taken : refusal(counters, status));
    if (status != Status::ok) return status;
    if (in_order(request.counter) == Status::ok) newest = request.counter;
    rank = stop_rank(request);
    return status;
  }

 private:
  Status in_order(std::int64_t counter) const {
    if (counter <= newest) return Status::time_repeated;
    return newest < 0 || counter - newest > kMostCounterStep ? Status::malformed : Status::ok;
  }

  template <class Request>
  Status judge(const Request& request, const RequestRules& rules, rt::Nanoseconds now_ns,
               StopOrder order) const {
    const std::uint32_t stops = stop_rank(request);
    const bool out_of_turn = stops != 0 && stops >= rank && order == StopOrder::any;
    if (const Status turn = in_order(request.counter); turn != Status::ok && !out_of_turn) return turn;
    if (stops != 0) return Status::ok;
    if (rules.is_too_old(request.stamp_ns, now_ns)) return Status::stale;
    return check_content(request, rules);
  }
};

}  // namespace sortie::planner
