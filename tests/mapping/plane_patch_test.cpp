// SPDX-License-Identifier: BSD-3-Clause
// Overlap of bounded planes against twins that look at corners, edges and points.
#include "mapping/registration/plane_patch.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/mapping/plane_scenes.hpp"

namespace {
using namespace sortie;
using Point = std::array<double, 2>;

mapping::PlanePatch random_patch(tests::WorldRandom& random, bool turned) {
  const double yaw = turned ? random.between(0, 6.28) : 0.0;
  const double a = random.between(0.1, 2), b = random.between(0.1, 2),
               skew = turned ? random.between(-0.15, 0.15) : 0;
  mapping::PlanePatch p;
  p.centre[0] = random.between(-2.5, 2.5), p.centre[1] = random.between(-2.5, 2.5);
  p.a[0] = a * std::cos(yaw), p.a[1] = a * std::sin(yaw);
  p.b[0] = -b * std::sin(yaw + skew), p.b[1] = b * std::cos(yaw + skew);
  return p;
}

std::vector<Point> corners(const mapping::PlanePatch& p) {
  std::vector<Point> all;
  for (const auto& s : {Point{1, 1}, Point{-1, 1}, Point{-1, -1}, Point{1, -1}})
    all.push_back({p.centre[0] + s[0] * p.a[0] + s[1] * p.b[0], p.centre[1] + s[0] * p.a[1] + s[1] * p.b[1]});
  return all;
}

/// By the two coordinates that a point has along the sides.
bool inside(const mapping::PlanePatch& p, const Point& x) {
  const double det = p.a[0] * p.b[1] - p.a[1] * p.b[0];
  const double dx = x[0] - p.centre[0], dy = x[1] - p.centre[1];
  return std::fabs((dx * p.b[1] - dy * p.b[0]) / det) <= 1 &&
         std::fabs((dy * p.a[0] - dx * p.a[1]) / det) <= 1;
}

bool edges_cross(const Point& p, const Point& q, const Point& r, const Point& s) {
  const auto side = [](const Point& a, const Point& b, const Point& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  };
  return side(p, q, r) * side(p, q, s) < 0 && side(r, s, p) * side(r, s, q) < 0;
}

/// Figures meet where a corner of one lies in the other or two edges cross.
bool meet(const mapping::PlanePatch& p, const mapping::PlanePatch& q) {
  const auto a = corners(p), b = corners(q);
  for (const Point& x : a) {
    if (inside(q, x)) return true;
  }
  for (const Point& x : b) {
    if (inside(p, x)) return true;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (edges_cross(a[i], a[(i + 1) % 4], b[k], b[(k + 1) % 4])) return true;
    }
  }
  return false;
}

/// Widest gap between the corners' shadows on the four directions.
double widest_gap(const mapping::PlanePatch& p, const mapping::PlanePatch& q) {
  double widest = -1e9;
  for (const auto* patch : {&p, &q}) {
    for (const auto* side : {&patch->a, &patch->b}) {
      const double length = std::hypot((*side)[0], (*side)[1]);
      const double n[2] = {-(*side)[1] / length, (*side)[0] / length};
      double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
      int k = 0;
      for (const auto& figure : {corners(p), corners(q)}) {
        for (const Point& x : figure) {
          low[k] = std::min(low[k], n[0] * x[0] + n[1] * x[1]);
          high[k] = std::max(high[k], n[0] * x[0] + n[1] * x[1]);
        }
        ++k;
      }
      widest = std::max(widest, std::max(low[1] - high[0], low[0] - high[1]));
    }
  }
  return widest;
}
}  // namespace

TEST_CASE("Patches overlap exactly where corners and edges say so, in either order") {
  tests::WorldRandom random(11);
  std::uint32_t met = 0, parted = 0;
  for (int i = 0; i < 20000; ++i) {
    const mapping::PlanePatch p = random_patch(random, i % 2 == 0);
    const mapping::PlanePatch q = random_patch(random, true);
    const bool truth = meet(p, q);
    REQUIRE(mapping::overlap(p, q, 0.0) == truth);
    REQUIRE(mapping::overlap(q, p, 0.0) == truth);
    const double margin = random.between(0, 1);
    const double gap = widest_gap(p, q);
    if (std::fabs(gap - margin) > 1e-9) REQUIRE(mapping::overlap(p, q, margin) == (gap < margin));
    ++(truth ? met : parted);
  }
  CHECK(met > 5000);
  CHECK(parted > 5000);
}

TEST_CASE("Common area against a count of points") {
  tests::WorldRandom random(12);
  double worst = 0.0;
  for (int i = 0; i < 300; ++i) {
    const mapping::PlanePatch own = random_patch(random, false);
    const mapping::PlanePatch q = random_patch(random, true);
    constexpr int kSide = 200;
    int hits = 0;
    for (int a = 0; a < kSide; ++a) {
      for (int b = 0; b < kSide; ++b) {
        const double s = (2 * a + 1.0) / kSide - 1, t = (2 * b + 1.0) / kSide - 1;
        if (inside(q, {own.centre[0] + s * own.a[0], own.centre[1] + t * own.b[1]})) ++hits;
      }
    }
    const double counted = mapping::area_of(own) * hits / (kSide * kSide);
    worst = std::max(worst, std::fabs(mapping::common_area(own, q) - counted) / mapping::area_of(own));
    CHECK(mapping::common_area(own, own) == Approx(mapping::area_of(own)));
  }
  CHECK(worst < 0.01);
}

TEST_CASE("A patch without width meets what it touches, and has no area") {
  mapping::PlanePatch line;
  line.a[0] = 1;
  mapping::PlanePatch square;
  square.a[0] = square.b[1] = 0.5;
  CHECK(mapping::overlap(square, line, 0.0));
  CHECK(mapping::common_area(square, line) == 0.0);
  line.centre[1] = 0.6;
  CHECK_FALSE(mapping::overlap(square, line, 0.0));
  CHECK(mapping::overlap(square, line, 0.2));
}
