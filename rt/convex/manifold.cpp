// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/manifold.hpp"

#include <algorithm>
#include <cmath>

#include "rt/convex/local.hpp"
#include "rt/convex/pair.hpp"
#include "rt/convex/support.hpp"

namespace sortie::rt::convex {
namespace {

// The points that are kept when there are too many: the deepest, then always the one farthest from all that
// are kept, which spans the largest area that few points can. Ties go to the first.
void choose(const Overlay& from, double margin_m, std::uint32_t most, std::uint32_t (&kept)[8],
            std::uint32_t& count) {
  double distance2[16];
  bool open[16];
  std::uint32_t candidates = 0;
  for (std::uint32_t i = 0; i < from.count; ++i) {
    open[i] = from.points[i].depth_m >= -margin_m;
    candidates += open[i] ? 1u : 0u;
    distance2[i] = 1e300;
  }
  count = 0;
  if (candidates <= most) {
    for (std::uint32_t i = 0; i < from.count; ++i) {
      if (open[i]) kept[count++] = i;
    }
    return;
  }
  bool chosen[16]{};
  for (std::uint32_t round = 0; round < most; ++round) {
    std::uint32_t next = 16;
    for (std::uint32_t i = 0; i < from.count; ++i) {
      if (!open[i]) continue;
      const bool better = next == 16 || (round == 0 ? from.points[i].depth_m > from.points[next].depth_m
                                                    : distance2[i] > distance2[next]);
      if (better) next = i;
    }
    open[next] = false;
    chosen[next] = true;
    for (std::uint32_t i = 0; i < from.count; ++i) {
      const Vector3 apart = from.points[i].point_m - from.points[next].point_m;
      distance2[i] = std::min(distance2[i], dot(apart, apart));
    }
  }
  for (std::uint32_t i = 0; i < from.count; ++i) {
    if (chosen[i]) kept[count++] = i;
  }
}

void fill(Manifold& out, const Overlay& points, const Vector3& normal, const Vector3& origin,
          const ManifoldOptions& options) {
  std::uint32_t kept[8]{};
  std::uint32_t count = 0;
  const std::uint32_t most = std::clamp(options.max_contacts, 4u, 8u);
  choose(points, std::max(options.margin_m, 0.0), most, kept, count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const OverlayPoint& p = points.points[kept[i]];
    out.contacts[i] = {origin + p.point_m, normal, p.depth_m, p.id};
  }
  out.count = count;
}

// Of what is no body.
Manifold unknown_contact() {
  Manifold out;
  out.state = State::unknown;
  out.count = 1;
  out.contacts[0].normal = {0.0, 0.0, 1.0};
  return out;
}

}  // namespace

Manifold manifold(const Convex& a, const Convex& b, const ManifoldOptions& options) {
  if (!is_valid(a) || !is_valid(b)) return unknown_contact();
  Manifold out;
  const double margin_m = std::max(options.margin_m, kTouching_m);
  const PairJudgement pair = judge_pair(a, b, margin_m, options.face_preference_m, options.budget);
  out.state = pair.state;
  fill(out, pair.points, pair.axis.direction, b.p_world_m, options);
  return out;
}

Manifold manifold(const Convex& a, const HalfSpace& ground, const ManifoldOptions& options) {
  const Vector3& n = ground.normal;
  if (!is_valid(a) || !is_finite(n) || !std::isfinite(ground.offset_m)) return unknown_contact();
  Manifold out;
  const double height = ground.offset_m - dot(n, a.p_world_m);  // of the plane over a's origin
  const double deepest = height + reach(a, -1.0 * n, a.p_world_m);
  out.state = deepest < -kTouching_m  ? State::separated
              : deepest > kTouching_m ? State::penetrating
                                      : State::touching;
  if (deepest < -std::max(options.margin_m, kTouching_m)) return out;
  const Feature down = feature(a, -1.0 * n);
  Overlay points;
  points.count = down.count;
  for (std::uint32_t i = 0; i < down.count; ++i) {
    const Vector3 p = down.vertices_m[i] - a.p_world_m;
    const double depth = height - dot(n, p);
    points.points[i] = {p + (0.5 * depth) * n, depth,
                        (static_cast<std::uint32_t>(down.id) << 24) | down.ids[i]};
  }
  fill(out, points, n, a.p_world_m, options);
  return out;
}

}  // namespace sortie::rt::convex
