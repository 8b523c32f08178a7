// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/nearest.hpp"

#include "rt/convex/local.hpp"
#include "rt/convex/support.hpp"

namespace sortie::rt::convex {
namespace {

constexpr double kExact_m = 1e-10;  // shorter than this is no distance
constexpr double kRelative = 1e-6;  // known to this share, the direction is right to a milliradian and its
                                    // overlap, which is flat there, to a millionth

// The part of a simplex that is nearest to the origin so far: up to three corners in order, and weights.
struct Part {
  std::uint32_t corners[3]{};
  double weights[3]{};
  std::uint32_t count{};
  double distance2{1e300};

  // True when a point is nearer; the caller writes corners and weights then.
  bool take(const Vector3& point, std::uint32_t corner_count) {
    const double squared = dot(point, point);
    if (!(squared < distance2)) return false;
    distance2 = squared;
    count = corner_count;
    return true;
  }
};

void corner_part(Part& best, const Simplex& s, std::uint32_t i) {
  if (!best.take(s.corners[i].difference, 1)) return;
  best.corners[0] = i;
  best.weights[0] = 1.0;
}

// The inner part of a segment, or nothing where the nearest point is an end.
void segment_part(Part& best, const Simplex& s, std::uint32_t i, std::uint32_t k) {
  const Vector3& p = s.corners[i].difference;
  const Vector3 along = s.corners[k].difference - p;
  const double length2 = dot(along, along);
  const double t = -dot(p, along);
  if (!(t > 0.0) || !(t < length2)) return;
  const double of_k = t / length2;
  const double of_i = 1.0 - of_k;
  if (!best.take(of_i * p + of_k * s.corners[k].difference, 2)) return;
  best.corners[0] = i;
  best.corners[1] = k;
  best.weights[0] = of_i;
  best.weights[1] = of_k;
}

// The inner part of a triangle, or nothing where the nearest point is on its border or the triangle is flat.
void triangle_part(Part& best, const Simplex& s, std::uint32_t i, std::uint32_t k, std::uint32_t m) {
  const Vector3& p = s.corners[i].difference;
  const Vector3 e1 = s.corners[k].difference - p;
  const Vector3 e2 = s.corners[m].difference - p;
  const Vector3 n = cross(e1, e2);
  const double n2 = dot(n, n);
  if (!(n2 > 1e-24 * dot(e1, e1) * dot(e2, e2)) || !(n2 > 0.0)) return;
  const double to_k = dot(cross(e2, p), n);  // areas over the edges, seen from the origin's foot point
  const double to_m = dot(cross(p, e1), n);
  if (!(to_k > 0.0) || !(to_m > 0.0) || !(to_k + to_m < n2)) return;
  const double of_k = to_k / n2;
  const double of_m = to_m / n2;
  const double of_i = 1.0 - of_k - of_m;
  const Vector3 nearest = of_i * p + of_k * s.corners[k].difference + of_m * s.corners[m].difference;
  if (!best.take(nearest, 3)) return;
  best.corners[0] = i;
  best.corners[1] = k;
  best.corners[2] = m;
  best.weights[0] = of_i;
  best.weights[1] = of_k;
  best.weights[2] = of_m;
}

// True when the origin is inside the tetrahedron, on its border included.
bool inside(const Simplex& s) {
  static constexpr std::uint32_t kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  for (const auto& face : kFaces) {
    const Vector3& p = s.corners[face[0]].difference;
    const Vector3 n = cross(s.corners[face[1]].difference - p, s.corners[face[2]].difference - p);
    const double inward = dot(n, s.corners[face[3]].difference - p);
    const double origin = -dot(n, p);
    if (inward == 0.0 || origin * inward < 0.0) return false;
  }
  return true;
}

// Drops the corners that the nearest point does not need and sets the weights; they are >= 0 and add up to 1.
// False when the origin lies inside a tetrahedron. Flat and collapsed simplices are judged by their parts
// (Ericson 2005, 5.1: by regions). Corners before `first_new` were reduced before: parts of them alone are
// not looked at again. 5-40 ns.
bool reduce(Simplex& simplex, std::uint32_t first_new = 0) {
  if (simplex.count == 4 && inside(simplex)) return false;
  Part best;
  for (std::uint32_t i = first_new; i < simplex.count; ++i) corner_part(best, simplex, i);
  for (std::uint32_t k = first_new; k < simplex.count; ++k) {
    for (std::uint32_t i = 0; i < k; ++i) segment_part(best, simplex, i, k);
  }
  for (std::uint32_t m = first_new; m < simplex.count; ++m) {
    for (std::uint32_t k = 1; k < m; ++k) {
      for (std::uint32_t i = 0; i < k; ++i) triangle_part(best, simplex, i, k, m);
    }
  }
  simplex.count = 0;
  for (std::uint32_t i = 0; i < best.count; ++i) {
    if (best.weights[i] == 0.0) continue;
    simplex.corners[simplex.count] = simplex.corners[best.corners[i]];
    simplex.weights[simplex.count] = best.weights[i];
    ++simplex.count;
  }
  return true;
}

// The nearest point, from the weights.
Vector3 nearest_difference(const Simplex& simplex) {
  Vector3 p{};
  for (std::uint32_t i = 0; i < simplex.count; ++i) {
    p = p + simplex.weights[i] * simplex.corners[i].difference;
  }
  return p;
}

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
  for (std::uint32_t i = 0; i < simplex.count; ++i) {
    result.on_a_m = result.on_a_m + simplex.weights[i] * simplex.corners[i].on_a;
    result.on_b_m = result.on_b_m + simplex.weights[i] * simplex.corners[i].on_b;
  }
  result.on_a_m = result.on_a_m + shift_m;
  return result;
}

}  // namespace sortie::rt::convex
