// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/overlay.hpp"

#include <cmath>

#include "rt/convex/local.hpp"

namespace sortie::rt::convex {
namespace {

constexpr double kSlack_m = 1e-5;  // see overlay()
constexpr double kPointSlack_m = 1e-4;
constexpr double kBeside_m = 5e-4;  // by which edges that are as good as parallel may lie beside each other
constexpr double kParallel = 0.1;   // edges within 6 deg touch along a line

// A feature seen along the direction: u and v across, h along it.
struct Corner {
  double u{};
  double v{};
  double h{};
  std::uint8_t out{};  // name of the edge that leaves this corner; the one before it leaves there
};

struct Flat {
  Corner corners[16]{};
  std::uint32_t count{};
};

struct View {
  Vector3 u;
  Vector3 v;
  Vector3 direction;
  Vector3 origin;

  Flat project(const Feature& f) const {
    Flat flat;
    flat.count = f.count;
    for (std::uint32_t i = 0; i < f.count; ++i) {
      const Vector3 p = f.vertices_m[i] - origin;
      flat.corners[i] = {dot(u, p), dot(v, p), dot(direction, p), f.ids[i]};
    }
    return flat;
  }
};

View view_along(const Vector3& d, const Vector3& origin) {
  const double x = std::fabs(d.x);
  const double y = std::fabs(d.y);
  const double z = std::fabs(d.z);
  const Vector3 least = x <= y && x <= z ? Vector3{1, 0, 0} : (y <= z ? Vector3{0, 1, 0} : Vector3{0, 0, 1});
  View view{cross(d, least), {}, d, origin};
  (void)normalise(view.u, view.u);  // never parallel: the least axis is at least 54 deg away
  view.v = cross(d, view.u);
  return view;
}

// The plane of a flat feature as a height over (u, v).
struct Plane {
  double u{};
  double v{};
  double h{};
  double at(double pu, double pv) const { return h + u * pu + v * pv; }
};

Plane plane_of(const Feature& f, const Flat& flat, const View& view) {
  const double along = dot(f.normal, view.direction);  // features face the direction within 15 deg
  Plane plane;
  plane.u = -dot(f.normal, view.u) / along;
  plane.v = -dot(f.normal, view.v) / along;
  plane.h = flat.corners[0].h - plane.u * flat.corners[0].u - plane.v * flat.corners[0].v;
  return plane;
}

Corner between(const Corner& p, const Corner& q, double t) {
  return {p.u + t * (q.u - p.u), p.v + t * (q.v - p.v), p.h + t * (q.h - p.h), p.out};
}

// Sutherland and Hodgman 1974: what lies left of the line from `from` to `to`. `name` becomes the name of the
// edge along that line. Polygons are convex, so a cut adds at most one corner.
void cut(Flat& polygon, const Corner& from, const Corner& to, std::uint8_t name) {
  const double eu = to.u - from.u;
  const double ev = to.v - from.v;
  const double length = std::sqrt(eu * eu + ev * ev);
  if (!(length > 1e-12)) return;
  const auto side = [&](const Corner& p) {
    return (eu * (p.v - from.v) - ev * (p.u - from.u)) / length + kSlack_m;
  };
  Flat kept;
  const bool segment = polygon.count == 2;
  const std::uint32_t edges = segment ? 1 : polygon.count;
  if (polygon.count == 1) {
    if (side(polygon.corners[0]) < 0.0) polygon.count = 0;
    return;
  }
  for (std::uint32_t i = 0; i < edges; ++i) {
    const Corner& p = polygon.corners[i];
    const Corner& q = polygon.corners[i + 1 == polygon.count ? 0 : i + 1];
    const double sp = side(p);
    const double sq = side(q);
    if (sp >= 0.0 && kept.count < 16) kept.corners[kept.count++] = p;
    if ((sp >= 0.0) != (sq >= 0.0) && kept.count < 16) {
      Corner crossing = between(p, q, sp / (sp - sq));
      if (sp >= 0.0 || segment) crossing.out = name;
      kept.corners[kept.count++] = crossing;
    }
    if (segment && sq >= 0.0 && kept.count < 16) kept.corners[kept.count++] = q;
  }
  polygon = kept;
}

struct Result {
  const View& view;
  std::uint32_t names;  // of the two features
  Overlay out{};
  void add(double u, double v, double height_a, double height_b, std::uint32_t name) {
    if (out.count == 16) return;
    OverlayPoint& p = out.points[out.count++];
    const double h = 0.5 * (height_a + height_b);
    p.point_m = view.origin + (u * view.u + v * view.v + h * view.direction);
    p.depth_m = height_b - height_a;
    p.id = names | name;
  }
};

// How far inside the outline a point lies.
double inset(const Flat& outline, double u, double v, double sign) {
  double least = 1e300;
  for (std::uint32_t i = 0; i < outline.count; ++i) {
    const Corner& p = outline.corners[i];
    const Corner& q = outline.corners[i + 1 == outline.count ? 0 : i + 1];
    const double eu = q.u - p.u;
    const double ev = q.v - p.v;
    const double length = std::sqrt(eu * eu + ev * ev);
    if (!(length > 1e-12)) continue;
    const double side = sign * (eu * (v - p.v) - ev * (u - p.u)) / length;
    if (side < least) least = side;
  }
  return least;
}

void measure_insets(Result& result, const Flat& outline, const Flat& common, bool outline_is_a) {
  Overlay& out = result.out;
  double u = 0.0;
  double v = 0.0;
  double depth = 0.0;
  std::uint32_t deepest = 0;
  for (std::uint32_t i = 0; i < common.count; ++i) {
    u += common.corners[i].u;
    v += common.corners[i].v;
    depth += out.points[i].depth_m;
    if (out.points[i].depth_m > out.points[deepest].depth_m) deepest = i;
  }
  const double share = 1.0 / static_cast<double>(common.count);
  const double sign = outline_is_a ? -1.0 : 1.0;  // a's outline is seen from behind
  out.inset_deepest_m = inset(outline, common.corners[deepest].u, common.corners[deepest].v, sign);
  out.inset_middle_m = inset(outline, share * u, share * v, sign);
  out.middle_depth_m = share * depth;
}

// `cutter` is flat; the other one is cut by its outline.
void against_polygon(Result& result, const Feature& cutter, const Feature& other, bool cutter_is_a) {
  const Flat outline = result.view.project(cutter);
  Flat rest = result.view.project(other);
  const Plane plane = plane_of(cutter, outline, result.view);
  for (std::uint32_t i = 0; i < outline.count && rest.count != 0; ++i) {
    const Corner& from = outline.corners[i];
    const Corner& to = outline.corners[i + 1 == outline.count ? 0 : i + 1];
    const auto name = static_cast<std::uint8_t>(8u + from.out);
    // Counter-clockwise from outside: for b that is from +direction, as this view; a is seen from behind.
    cut(rest, cutter_is_a ? to : from, cutter_is_a ? from : to, name);
  }
  if (rest.count == 0) return;
  const bool closed = rest.count > 2;
  for (std::uint32_t i = 0; i < rest.count; ++i) {
    const Corner& p = rest.corners[i];
    const std::uint32_t before = closed ? rest.corners[i == 0 ? rest.count - 1 : i - 1].out : 0u;
    const double over = plane.at(p.u, p.v);
    result.add(p.u, p.v, cutter_is_a ? over : p.h, cutter_is_a ? p.h : over, (before << 4) | p.out);
  }
  measure_insets(result, outline, rest, cutter_is_a);
}

// Nearest points of two edges in the view, or the ends of what they share where they are as good as parallel.
void edge_edge(Result& result, const Flat& a, const Flat& b) {
  const double au = a.corners[1].u - a.corners[0].u;
  const double av = a.corners[1].v - a.corners[0].v;
  const double bu = b.corners[1].u - b.corners[0].u;
  const double bv = b.corners[1].v - b.corners[0].v;
  const double la = std::sqrt(au * au + av * av);
  const double lb = std::sqrt(bu * bu + bv * bv);
  if (!(la > 1e-9) || !(lb > 1e-9)) return;
  const double ru = b.corners[0].u - a.corners[0].u;
  const double rv = b.corners[0].v - a.corners[0].v;
  const double product = au * bv - av * bu;
  if (std::fabs(product) > kParallel * la * lb) {
    const double s = (ru * bv - rv * bu) / product;
    const double t = (ru * av - rv * au) / product;
    const double slack_s = kSlack_m / la;
    const double slack_t = kSlack_m / lb;
    if (s < -slack_s || s > 1.0 + slack_s || t < -slack_t || t > 1.0 + slack_t) return;
    const Corner p = between(a.corners[0], a.corners[1], s);
    const Corner q = between(b.corners[0], b.corners[1], t);
    result.add(p.u, p.v, p.h, q.h, 0xff);
    return;
  }
  // Along a: b from t0 to t1; they must lie on each other within the slack somewhere in the shared part.
  double t[2];
  double across[2];
  for (int i = 0; i < 2; ++i) {
    const double u = b.corners[i].u - a.corners[0].u;
    const double v = b.corners[i].v - a.corners[0].v;
    t[i] = (u * au + v * av) / (la * la);
    across[i] = (au * v - av * u) / la;
  }
  if (!(std::fabs(t[1] - t[0]) > 1e-9)) return;
  const int first = t[0] <= t[1] ? 0 : 1;
  const double low = t[first] > 0.0 ? t[first] : 0.0;
  const double high = t[1 - first] < 1.0 ? t[1 - first] : 1.0;
  if (high < low) return;
  const auto beside = [&](double along) {
    return across[0] + (along - t[0]) / (t[1] - t[0]) * (across[1] - across[0]);
  };
  // What lies within the limit of `beside` is the shared part: edges that cross at an angle share little.
  double from = low;
  double to = high;
  const double slope = (across[1] - across[0]) / (t[1] - t[0]);
  if (std::fabs(slope) > 1e-12) {
    const double one = t[0] + (-kBeside_m - across[0]) / slope;
    const double two = t[0] + (kBeside_m - across[0]) / slope;
    from = std::fmax(from, std::fmin(one, two));
    to = std::fmin(to, std::fmax(one, two));
  }
  if (to < from || std::fabs(beside(0.5 * (from + to))) > kBeside_m) return;
  for (int end = 0; end < 2; ++end) {
    const double along = end == 0 ? from : to;
    const Corner p = between(a.corners[0], a.corners[1], along);
    const Corner q = between(b.corners[0], b.corners[1], (along - t[0]) / (t[1] - t[0]));
    result.add(0.5 * (p.u + q.u), 0.5 * (p.v + q.v), p.h, q.h, end == 0 ? 0xf0u : 0xf1u);
  }
}

void point_on_edge(Result& result, const Corner& point, const Flat& edge, bool point_is_a) {
  const double eu = edge.corners[1].u - edge.corners[0].u;
  const double ev = edge.corners[1].v - edge.corners[0].v;
  const double length2 = eu * eu + ev * ev;
  if (!(length2 > 1e-18)) return;
  double t = ((point.u - edge.corners[0].u) * eu + (point.v - edge.corners[0].v) * ev) / length2;
  t = t < 0.0 ? 0.0 : (t > 1.0 ? 1.0 : t);
  const Corner q = between(edge.corners[0], edge.corners[1], t);
  const double du = q.u - point.u;
  const double dv = q.v - point.v;
  if (du * du + dv * dv > kPointSlack_m * kPointSlack_m) return;
  result.add(point.u, point.v, point_is_a ? point.h : q.h, point_is_a ? q.h : point.h, 0xfe);
}

}  // namespace

Overlay overlay(const Feature& of_a, const Feature& of_b, const Vector3& direction) {
  const View view = view_along(direction, of_b.vertices_m[0]);
  Result result{view,
                (static_cast<std::uint32_t>(of_a.id) << 24) | (static_cast<std::uint32_t>(of_b.id) << 16)};
  if (of_a.flat || of_b.flat) {
    // The face that looks along the direction more exactly cuts the other one; b where they are equal.
    const double look_a = of_a.flat ? -dot(of_a.normal, direction) : 0.0;
    const double look_b = of_b.flat ? dot(of_b.normal, direction) : 0.0;
    const bool a_cuts = look_a > look_b + 1e-9;
    against_polygon(result, a_cuts ? of_a : of_b, a_cuts ? of_b : of_a, a_cuts);
    return result.out;
  }
  const Flat a = view.project(of_a);
  const Flat b = view.project(of_b);
  if (a.count == 2 && b.count == 2) {
    edge_edge(result, a, b);
  } else if (a.count == 1 && b.count == 2) {
    point_on_edge(result, a.corners[0], b, true);
  } else if (a.count == 2 && b.count == 1) {
    point_on_edge(result, b.corners[0], a, false);
  } else if (a.count == 1 && b.count == 1) {
    const double du = a.corners[0].u - b.corners[0].u;
    const double dv = a.corners[0].v - b.corners[0].v;
    if (du * du + dv * dv <= kPointSlack_m * kPointSlack_m) {
      result.add(a.corners[0].u, a.corners[0].v, a.corners[0].h, b.corners[0].h, 0xfd);
    }
  }
  return result.out;
}

}  // namespace sortie::rt::convex
