// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/nearest.hpp"

#include "rt/convex/local.hpp"
#include "rt/convex/simplex.hpp"
#include "rt/convex/support.hpp"

namespace sortie::rt::convex {
namespace {

constexpr double kExact_m = 1e-10;  // shorter than this is no distance
constexpr double kRelative = 1e-6;  // known to this share, the direction is right to a milliradian and its
                                    // overlap, which is flat there, to a millionth

}  // namespace

NearestResult nearest_points(const Convex& a, const Vector3& shift_m, const Convex& b, const Vector3& start,
                             std::uint32_t budget, Simplex& simplex) {
  NearestResult result;
  Vector3 between = start;  // from the nearest point of b known so far to that of a
  double distance = 0.0;
  for (std::uint32_t i = 0; i < simplex.count; ++i) {
    SimplexCorner& corner = simplex.corners[i];
    corner.difference = (corner.on_a + shift_m) - corner.on_b;
  }
  if (simplex.count != 0) {
    if (!reduce(simplex)) return result;
    between = nearest_difference(simplex);
    distance = norm(between);
  }
  while (result.support_calls + 2 <= budget) {
    SimplexCorner corner;
    corner.on_b = support(b, between);
    corner.on_a = support(a, -1.0 * between);
    corner.difference = (corner.on_a + shift_m) - corner.on_b;
    result.support_calls += 2;
    // All of a - b lies beyond this corner's plane: the distance is at least its distance along `between`.
    if (simplex.count != 0 &&
        distance * distance - dot(between, corner.difference) <= kRelative * distance * distance) {
      break;
    }
    Simplex trial = simplex;
    trial.corners[trial.count++] = corner;
    if (!reduce(trial, simplex.count)) return result;  // they meet
    const Vector3 nearer = nearest_difference(trial);
    const double nearer_distance = norm(nearer);
    if (simplex.count != 0 && !(nearer_distance < distance)) break;  // rounding has the last word
    simplex = trial;
    between = nearer;
    distance = nearer_distance;
    if (distance < kExact_m) break;
  }
  if (!(distance > kExact_m) || !normalise(between, result.direction)) return result;
  result.apart = true;
  result.distance_m = distance;
  for (std::uint32_t i = 0; i < simplex.count; ++i) {
    result.on_a_m = result.on_a_m + simplex.weights[i] * simplex.corners[i].on_a;
    result.on_b_m = result.on_b_m + simplex.weights[i] * simplex.corners[i].on_b;
  }
  result.on_a_m = result.on_a_m + shift_m;
  return result;
}

}  // namespace sortie::rt::convex
