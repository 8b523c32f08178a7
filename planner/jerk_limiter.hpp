// SPDX-License-Identifier: BSD-3-Clause
// Takes a value to its set-point with limited acceleration and limited jerk, on discrete steps, without ever
// passing it.
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/describe.hpp"

namespace sortie::planner {

/// Limits of one axis: of the value's rate, and of that rate's rate. Both above 0.
struct RampLimits {
  double acceleration{};
  double jerk{};
};

/// An axis in motion. Units are the caller's: m/s with m/s^2, or rad/s with rad/s^2. The jerk is constant
/// within a step, so that v' = v + (a + a') dt / 2 is exact, and everything below is exact for that motion,
/// not an approximation of a continuous one. 16 bytes.
struct JerkLimiter {
  double value{};
  double rate{};
  SORTIE_FIELDS(value, rate)

  /// How far the value still goes while its rate fades at the full jerk: the rates of the coming steps are
  /// |a|, |a| - q, |a| - 2q, ..., 0 with q = jerk * dt, and their trapezoids sum up to
  /// D = dt ((n - 1/2) |a| - q n (n - 1) / 2), n = ceil(|a| / q). Continuous, rising and convex in |a|.
  double run_out(double jerk, double dt_s) const {
    const double quantum = jerk * dt_s;
    const double size = std::fabs(rate);
    const double n = std::ceil(size / quantum);
    return std::copysign(dt_s * ((n - 0.5) * size - 0.5 * quantum * n * (n - 1.0)), rate);
  }

  /// The value at which it comes to rest if it is told to now.
  double rest_value(double jerk, double dt_s) const {
    return rate == 0.0 ? value : value + run_out(jerk, dt_s);
  }

  /// The value of largest size that it goes through before it can be at rest.
  double reach(double jerk, double dt_s) const {
    return std::max(std::fabs(value), std::fabs(rest_value(jerk, dt_s)));
  }

  /// True when it can come to rest at `target` without passing it, within these limits.
  bool can_keep(double target, const RampLimits& limits, double dt_s) const {
    constexpr double kRounding = 1e-9;
    if (std::fabs(rate) > limits.acceleration * (1.0 + kRounding)) return false;
    if (rate == 0.0) return true;
    const double way = rate > 0.0 ? target - value : value - target;
    return std::fabs(run_out(limits.jerk, dt_s)) <= way * (1.0 + kRounding) + 1e-12;
  }

  /// One step of `dt_s` > 0 toward a finite `target`. Takes the largest rate from which the target can still
  /// be reached without passing it: with e the way that is left after the half-step that the present rate
  /// decides, the rate a' solves e = dt (n a' - q n (n - 1) / 2), n = ceil((sqrt(1 + 8 e / (q dt)) - 1) / 2).
  /// Where passing cannot be avoided (the target moved back while the rate was high, or a limit was lowered)
  /// it goes past by run_out() at most and returns. Lands on the target exactly and stays there. Cost: one
  /// square root, two divisions; no loop.
  void step(double target, const RampLimits& limits, double dt_s) {
    const double quantum = limits.jerk * dt_s;
    const double left = (target - value) / dt_s - 0.5 * rate;
    const double size = std::fabs(left);
    const double n = std::max(1.0, std::ceil(0.5 * (std::sqrt(1.0 + 8.0 * size / quantum) - 1.0)));
    const double wish = std::copysign((size + 0.5 * quantum * n * (n - 1.0)) / n, left);
    const double allowed = std::clamp(wish, -limits.acceleration, limits.acceleration);
    // The jerk comes last: a rate above a limit that was lowered is led down, not cut.
    const double next = std::clamp(allowed, rate - quantum, rate + quantum);
    value += 0.5 * (rate + next) * dt_s;
    rate = next;
    // What rounding leaves over is far below one step of the jerk.
    const double still = 1e-9 * quantum + 1e-15 * std::fabs(target) / dt_s;
    if (std::fabs(rate) <= still && std::fabs(value - target) <= still * dt_s) {
      value = target;
      rate = 0.0;
    }
  }
};

}  // namespace sortie::planner
