// SPDX-License-Identifier: BSD-3-Clause
// What judges rt/convex, written apart from it: how far bodies reach, by their circles and corners; whether
// they share a point, by projecting to and fro; and how deep they are, by trying directions all over the
// sphere.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "rt/convex/query.hpp"
#include "rt/convex/shape.hpp"
#include "rt/convex/support.hpp"

namespace sortie::rt::convex::test {

/// Numbers from a printed seed, the same everywhere.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : bits_(seed) {}
  double within(double low, double high) {
    return low + (high - low) * (static_cast<double>(bits_() >> 11) * 0x1p-53);
  }
  bool chance(double p) { return within(0.0, 1.0) < p; }
  int below(int n) { return static_cast<int>(bits_() % static_cast<std::uint64_t>(n)); }
  Vector3 direction() {
    for (;;) {
      const double x = within(-1, 1);
      const double y = within(-1, 1);
      const double z = within(-1, 1);
      const Vector3 v{x, y, z};
      const double n2 = dot(v, v);
      if (n2 > 0.01 && n2 < 1.0) return (1.0 / std::sqrt(n2)) * v;
    }
  }
  Quaternion turn() {
    const double w = within(-1, 1);
    const double x = within(-1, 1);
    const double y = within(-1, 1);
    const double z = within(-1, 1);
    return normalised({w, x, y, z});
  }

 private:
  std::mt19937_64 bits_;
};

/// A box like a stair, a slat, a brick or the ground.
inline Convex any_box(Draw& draw) {
  const double x = draw.within(0.02, 0.6);
  const double y = draw.within(0.02, 1.0);
  const double z = draw.within(0.01, 0.4);
  return make_box({x, y, z});
}

/// A track, a flipper or a cylinder.
inline Convex any_track(Draw& draw) {
  const int kind = draw.below(4);
  if (kind == 0) return make_track(0.09047, 0.09047, 0.5, 0.04865);
  if (kind == 1) return make_track(0.089, 0.029, 0.33, 0.0249);
  const double r0 = draw.within(0.02, 0.3);
  const double r1 = draw.within(0.02, 0.3);
  const double length = draw.within(0.0, 0.8);
  const double width = draw.within(0.01, 0.4);
  return kind == 2 ? make_track(r0, r1, length, width) : make_cylinder(r0, width);
}

inline Vector3 column(const Convex& c, int i) {
  return {c.R_world_body.m[i], c.R_world_body.m[i + 3], c.R_world_body.m[i + 6]};
}

/// Largest d.x over the body: a box by its eight corners, a track by its four rims.
inline double reach_by_parts(const Convex& c, const Vector3& d) {
  double most = -1e300;
  if (c.kind == Kind::box) {
    for (int corner = 0; corner < 8; ++corner) {
      Vector3 p = c.p_world_m;
      p = p + ((corner & 1) != 0 ? c.half_m.x : -c.half_m.x) * column(c, 0);
      p = p + ((corner & 2) != 0 ? c.half_m.y : -c.half_m.y) * column(c, 1);
      p = p + ((corner & 4) != 0 ? c.half_m.z : -c.half_m.z) * column(c, 2);
      most = std::max(most, dot(d, p));
    }
    return most;
  }
  const Vector3 y = column(c, 1);
  const double along = dot(y, d);
  const Vector3 flat = d - along * y;  // the part of d in the rims' planes
  for (int rim = 0; rim < 4; ++rim) {
    const double x = c.first_x_m + ((rim & 1) != 0 ? c.length_m : 0.0);
    const Vector3 centre = c.p_world_m + x * column(c, 0) + ((rim & 2) != 0 ? c.half_m.y : -c.half_m.y) * y;
    most = std::max(most, dot(d, centre) + c.radius_m[rim & 1] * norm(flat));
  }
  return most;
}

/// The overlap along a direction from b into a.
inline double overlap_by_parts(const Convex& a, const Convex& b, const Vector3& d) {
  return reach_by_parts(b, d) + reach_by_parts(a, -1.0 * d);
}

/// The point of the body nearest to `p`: by clamping for a box; for a track, across its width by clamping and
/// in the plane of its wheels the nearest of: the point itself, both circles and both runs.
inline Vector3 nearest_in(const Convex& c, const Vector3& p) {
  const Vector3 r = p - c.p_world_m;
  double q[3] = {dot(r, column(c, 0)), dot(r, column(c, 1)), dot(r, column(c, 2))};
  q[1] = std::clamp(q[1], -c.half_m.y, c.half_m.y);
  if (c.kind == Kind::box) {
    q[0] = std::clamp(q[0], -c.half_m.x, c.half_m.x);
    q[2] = std::clamp(q[2], -c.half_m.z, c.half_m.z);
  } else {
    const double x = q[0] - c.first_x_m;
    const double z = std::fabs(q[2]);
    const double r0 = c.radius_m[0];
    const double r1 = c.radius_m[1];
    const double length = c.length_m;
    const double from_0 = std::sqrt(x * x + z * z);
    const double from_1 = std::sqrt((x - length) * (x - length) + z * z);
    const double sine = length > 0.0 ? (r0 - r1) / length : 0.0;
    const double cosine = std::sqrt(1.0 - sine * sine);
    // Between the two radii that end on the upper run, and below it.
    const double along = x * cosine - z * sine;
    const bool by_run = length > 0.0 && along > 0.0 && along < length * cosine;
    const double over = x * sine + z * cosine - r0;
    if (by_run && over > 0.0) {
      q[0] -= over * sine;
      q[2] = std::copysign(z - over * cosine, q[2]);
    } else if (!by_run && along <= 0.0 && from_0 > r0) {
      q[0] = c.first_x_m + x * r0 / from_0;
      q[2] = std::copysign(z * r0 / from_0, q[2]);
    } else if (!by_run && along > 0.0 && from_1 > r1) {
      q[0] = c.first_x_m + length + (x - length) * r1 / from_1;
      q[2] = std::copysign(z * r1 / from_1, q[2]);
    }
  }
  return c.p_world_m + q[0] * column(c, 0) + q[1] * column(c, 1) + q[2] * column(c, 2);
}

/// An upper bound of the gap, 0 when they meet: von Neumann's alternating projections, until the bound is
/// below `enough` or the rounds are over. It falls to the true gap from above, slowly between surfaces that
/// graze each other unless the start is good.
inline double gap_from_above(const Convex& a, const Convex& b, double enough, int rounds,
                             const Vector3& start) {
  Vector3 p = nearest_in(b, start);
  double gap = 1e300;
  for (int i = 0; i < rounds && gap > enough; ++i) {
    const Vector3 q = nearest_in(a, p);
    p = nearest_in(b, q);
    gap = std::min(gap, norm(p - q));
  }
  return gap;
}

/// The smallest overlap of all directions: a spiral over the sphere, then each of the best starts is improved
/// by steps along and across that halve when none helps.
inline double depth_by_search(const Convex& a, const Convex& b, int directions, int starts,
                              Vector3* best_out = nullptr) {
  struct Try {
    double overlap;
    Vector3 d;
  };
  std::vector<Try> tries;
  for (int i = 0; i < directions; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / directions;
    const double s = std::sqrt(1.0 - z * z);
    const double turn = 2.399963229728653 * i;
    const SinCos at = sincos(turn);
    const Vector3 d{s * at.cos, s * at.sin, z};
    tries.push_back({overlap_by_parts(a, b, d), d});
  }
  const auto count = std::min<std::size_t>(tries.size(), static_cast<std::size_t>(40 * starts));
  std::partial_sort(tries.begin(), tries.begin() + static_cast<std::ptrdiff_t>(count), tries.end(),
                    [](const Try& l, const Try& r) { return l.overlap < r.overlap; });
  double best = 1e300;
  std::vector<Vector3> used;
  for (std::size_t i = 0; i < count && static_cast<int>(used.size()) < starts; ++i) {
    Try at = tries[i];
    const bool known =
        std::any_of(used.begin(), used.end(), [&](const Vector3& d) { return dot(d, at.d) > 0.99; });
    if (known) continue;
    used.push_back(at.d);
    int rounds = 0;
    for (double step = 0.05; step > 1e-5 && rounds < 400; ++rounds) {
      const Vector3 side = std::fabs(at.d.x) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
      Vector3 u = cross(at.d, side);
      u = (1.0 / norm(u)) * u;
      const Vector3 v = cross(at.d, u);
      bool better = false;
      for (int k = 0; k < 16; ++k) {
        const SinCos angle = sincos(0.39269908169872414 * k);
        Vector3 d = at.d + step * (angle.cos * u + angle.sin * v);
        d = (1.0 / norm(d)) * d;
        const double overlap = overlap_by_parts(a, b, d);
        if (overlap < at.overlap) {
          at = {overlap, d};
          better = true;
          break;
        }
      }
      if (!better) step *= 0.5;
    }
    if (at.overlap < best) {
      best = at.overlap;
      if (best_out != nullptr) *best_out = at.d;
    }
  }
  return best;
}

/// Puts a so that it overlaps b by `overlap` along a direction: any one, a face of either, or a product of
/// edges, with the outermost points of both opposite each other, or a random point of the face.
inline void put_shallow(Draw& draw, Convex& a, const Convex& b, double overlap) {
  a.R_world_body = to_matrix(draw.turn());
  Vector3 d = draw.direction();
  const int kind = draw.below(4);
  const double sign = draw.chance(0.5) ? 1.0 : -1.0;
  const int one = draw.below(3);
  const int other = draw.below(2);
  if (kind == 1) d = sign * column(b, one);
  if (kind == 2) d = sign * column(a, one);
  if (kind == 3) {
    const Vector3 product = cross(column(a, other), column(b, one));
    if (norm(product) > 0.1) d = (1.0 / norm(product)) * product;
  }
  Vector3 on_b = support(b, d);
  if (kind == 1) {  // anywhere on the face
    const Vector3 lateral = draw.direction();
    const double size = draw.within(0.0, 0.5);
    on_b = nearest_in(b, on_b + size * (lateral - dot(lateral, d) * d));
  }
  a.p_world_m = {};
  a.p_world_m = on_b - support(a, -1.0 * d) - overlap * d;
}

}  // namespace sortie::rt::convex::test
