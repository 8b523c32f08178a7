// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/simplex.hpp"

namespace sortie::rt::convex {
namespace {

// Weights of the point nearest to the origin on a part of a simplex; zero for corners that it does not need.
struct Part {
  double weights[4]{};
  double distance2{1e300};
};

void keep_nearer(Part& best, const Simplex& s, const double (&weights)[4]) {
  Vector3 p{};
  for (std::uint32_t i = 0; i < s.count; ++i) p = p + weights[i] * s.corners[i].difference;
  const double distance2 = dot(p, p);
  if (!(distance2 < best.distance2)) return;
  best.distance2 = distance2;
  for (int i = 0; i < 4; ++i) best.weights[i] = weights[i];
}

void corner_part(Part& best, const Simplex& s, std::uint32_t i) {
  double weights[4]{};
  weights[i] = 1.0;
  keep_nearer(best, s, weights);
}

// The inner part of a segment, or nothing where the nearest point is an end.
void segment_part(Part& best, const Simplex& s, std::uint32_t i, std::uint32_t k) {
  const Vector3& p = s.corners[i].difference;
  const Vector3 along = s.corners[k].difference - p;
  const double length2 = dot(along, along);
  const double t = -dot(p, along);
  if (!(t > 0.0) || !(t < length2)) return;
  double weights[4]{};
  weights[k] = t / length2;
  weights[i] = 1.0 - weights[k];
  keep_nearer(best, s, weights);
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
  double weights[4]{};
  weights[k] = to_k / n2;
  weights[m] = to_m / n2;
  weights[i] = 1.0 - weights[k] - weights[m];
  keep_nearer(best, s, weights);
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

}  // namespace

bool reduce(Simplex& simplex) {
  if (simplex.count == 4 && inside(simplex)) return false;
  Part best;
  for (std::uint32_t i = 0; i < simplex.count; ++i) corner_part(best, simplex, i);
  for (std::uint32_t i = 0; i < simplex.count; ++i) {
    for (std::uint32_t k = i + 1; k < simplex.count; ++k) segment_part(best, simplex, i, k);
  }
  for (std::uint32_t i = 0; i < simplex.count; ++i) {
    for (std::uint32_t k = i + 1; k < simplex.count; ++k) {
      for (std::uint32_t m = k + 1; m < simplex.count; ++m) triangle_part(best, simplex, i, k, m);
    }
  }
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < simplex.count; ++i) {
    if (best.weights[i] == 0.0) continue;
    simplex.corners[kept] = simplex.corners[i];
    simplex.weights[kept] = best.weights[i];
    ++kept;
  }
  simplex.count = kept;
  return true;
}

Vector3 nearest_difference(const Simplex& simplex) {
  Vector3 p{};
  for (std::uint32_t i = 0; i < simplex.count; ++i) {
    p = p + simplex.weights[i] * simplex.corners[i].difference;
  }
  return p;
}

}  // namespace sortie::rt::convex
