// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/descent.hpp"

#include <algorithm>

#include "rt/convex/nearest.hpp"

namespace sortie::rt::convex {
namespace {

constexpr int kDescents = 3;
constexpr std::uint32_t kCallsARound = 24;
constexpr double kLeastGain_m = 1e-7;  // an improvement smaller than this ends the search

Vector3 middle_of(const NearestResult& nearest, const Vector3& shift) {
  return 0.5 * ((nearest.on_a_m - shift) + nearest.on_b_m);
}

}  // namespace

Descent descend(const Convex& a, const Convex& b, const Vector3& start, double clearance_m,
                std::uint32_t& calls_left) {
  Descent result{{start, overlap_along(a, b, start)}, {}, false};
  Simplex simplex;
  for (int round = 0; round < kDescents && result.axis.overlap_m > 0.0; ++round) {
    const Vector3 shift = (result.axis.overlap_m + clearance_m) * result.axis.direction;
    const NearestResult nearest =
        nearest_points(a, shift, b, result.axis.direction, std::min(calls_left, kCallsARound), simplex);
    calls_left -= nearest.support_calls;
    if (!nearest.apart) break;
    const Axis next{nearest.direction, overlap_along(a, b, nearest.direction)};
    const double before = result.axis.overlap_m;
    if (next.overlap_m <= before || !result.found) result.point_m = middle_of(nearest, shift);
    if (next.overlap_m <= before) result.axis = next;  // else the round ended before it was exact
    result.found = true;
    if (next.overlap_m > before - kLeastGain_m) break;
  }
  return result;
}

Descent nearest_direction(const Convex& a, const Convex& b, const Vector3& start, std::uint32_t& calls_left) {
  Simplex simplex;
  const NearestResult nearest = nearest_points(a, {}, b, start, calls_left, simplex);
  calls_left -= nearest.support_calls;
  if (!nearest.apart) return {};
  return {{nearest.direction, overlap_along(a, b, nearest.direction)}, middle_of(nearest, {}), true};
}

}  // namespace sortie::rt::convex
