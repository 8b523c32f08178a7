// SPDX-License-Identifier: BSD-3-Clause
// The support function against a hull of points, and the pivot against the closed form of a body that leans
// on a step.
#include "estimators/obstacle_geometry.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

namespace {

using sortie::estimators::FlipperAngles;
using sortie::estimators::OutlineEnd;
using sortie::estimators::Support;
using sortie::estimators::TrackProfile;

struct OutlinePoint {
  double x, z;
};

/// The rims of all discs as points: their convex hull is the outline.
std::vector<OutlinePoint> outline_points(const TrackProfile& p, const FlipperAngles& f, int from, int to) {
  std::vector<OutlinePoint> points;
  const auto rim = [&](double x, double z, double r) {
    constexpr int kPoints = 4000;
    for (int i = 0; i < kPoints; ++i) {
      const double a = 6.283185307179586 * i / kPoints;
      points.push_back({x + r * std::cos(a), z + r * std::sin(a)});
    }
  };
  for (int end = from; end <= to; ++end) {
    const double ahead = end == 0 ? -1 : 1;
    const double angle = end == 0 ? f.rear_rad : f.front_rad;
    rim(ahead * p.half_length_m, p.axle_m, p.radius_m);
    if (!p.flippers) continue;
    rim(ahead * p.pivot_x_m, p.pivot_z_m, p.pivot_radius_m);
    rim(ahead * (p.pivot_x_m + p.flipper_m * std::cos(angle)), p.pivot_z_m + p.flipper_m * std::sin(angle),
        p.tip_radius_m);
  }
  return points;
}

}  // namespace

TEST_CASE("The support function is that of the outline's points, with flippers anywhere") {
  const unsigned seed = 20261;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  TrackProfile profile;
  for (int i = 0; i < 60; ++i) {
    profile.flippers = i % 4 != 0;
    const FlipperAngles flippers{uniform(-1.2, 2.8), uniform(-1.2, 2.8)};
    const double d = uniform(-1.0, 1.0);
    for (const OutlineEnd end : {OutlineEnd::rear, OutlineEnd::front, OutlineEnd::both}) {
      double height = -1e9;
      for (const OutlinePoint& p : outline_points(profile, flippers, end == OutlineEnd::front ? 1 : 0,
                                                  end == OutlineEnd::rear ? 0 : 1))
        height = std::max(height, -(p.x * std::sin(d) + p.z * std::cos(d)));
      const Support support = support_of(profile, end, d, flippers);
      REQUIRE(support.height_m == Approx(height).margin(1e-6));
      REQUIRE(-(support.x_m * std::sin(d) + support.z_m * std::cos(d)) ==
              Approx(support.height_m).margin(1e-12));
    }
  }
}

TEST_CASE(
    "A body on a plane stands as high as its run is low, and level or not its ends are where they are") {
  const TrackProfile profile;
  const Support level = support_of(profile, OutlineEnd::both, 0.0, {2.7, 2.7});
  CHECK(level.height_m == Approx(-profile.run_m()));
  // Nose up: the rear wheel carries, h = r + a sin d - z cos d.
  const double d = 0.3;
  const Support rear = support_of(profile, OutlineEnd::both, d, {2.7, 2.7});
  CHECK(rear.height_m ==
        Approx(profile.radius_m + profile.half_length_m * std::sin(d) - profile.axle_m * std::cos(d))
            .margin(1e-12));
}

TEST_CASE("The pivot of a body that leans on an edge is the edge, at every pitch") {
  TrackProfile p;
  p.flippers = false;
  for (const double height : {0.05, 0.1, 0.15}) {
    for (double d = 0.1; d < 0.6; d += 0.05) {
      // Way of the edge on the run, from the rear wheel: height = r (1 - cos d) + s sin d; the wheel's centre
      // lies s cos d + r sin d before the edge, and without slip at the rear the belt runs as far as that
      // centre moves, and r for each rad of turn.
      const auto way = [&](double t) { return (height - p.radius_m * (1 - std::cos(t))) / std::sin(t); };
      const auto belt = [&](double t) {
        return -way(t) * std::cos(t) - p.radius_m * std::sin(t) + p.radius_m * t;
      };
      const double step = 1e-5;
      const double curvature = 2 * step / (belt(d + step) - belt(d - step));
      const Support rear = support_of(p, OutlineEnd::rear, d, {});
      const double pivot = pivot_on_run(rear, d, curvature);
      const double edge = way(d) - p.half_length_m;
      REQUIRE(pivot == Approx(edge).margin(1e-5));
      REQUIRE(edge_height_m(p, rear, edge, d) == Approx(height).margin(1e-9));
    }
  }
}

TEST_CASE("The balance point lies below the centre of mass and never off the run") {
  const TrackProfile p;
  for (double pitch = -1.5; pitch < 1.5; pitch += 0.1) {
    const double x = balance_on_run_m(p, pitch);
    REQUIRE(std::fabs(x) <= p.half_length_m);
    if (std::fabs(pitch) > 0.6 || std::fabs(x) == p.half_length_m) continue;
    // The line from there to the centre of mass stands upright.
    const double dx = p.com_x_m - x;
    const double dz = p.com_z_m - p.run_m();
    REQUIRE(dx * std::cos(pitch) - dz * std::sin(pitch) == Approx(0).margin(1e-12));
  }
}
