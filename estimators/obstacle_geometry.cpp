// SPDX-License-Identifier: BSD-3-Clause
#include "estimators/obstacle_geometry.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::estimators {
namespace {

constexpr double kSteepest_rad = 1.2;  // beyond it the balance point leaves every run

/// Takes the lower of what is there and one more disc.
struct Lowest {
  rt::SinCos d;
  Support best{-1e9, 0.0, 0.0};

  void disc(double x, double z, double r) {
    const double height = r - x * d.sin - z * d.cos;
    if (height > best.height_m) best = {height, x - r * d.sin, z - r * d.cos};
  }
};

}  // namespace

Support support_of(const TrackProfile& p, OutlineEnd end, double nose_up_rad, const FlipperAngles& flippers) {
  Lowest lowest{rt::sincos(nose_up_rad)};
  for (int i = 0; i < 2; ++i) {
    if (end == (i == 0 ? OutlineEnd::front : OutlineEnd::rear)) continue;
    const double ahead = i == 0 ? -1.0 : 1.0;
    lowest.disc(ahead * p.half_length_m, p.axle_m, p.radius_m);
    if (!p.flippers) continue;
    const rt::SinCos f = rt::sincos(i == 0 ? flippers.rear_rad : flippers.front_rad);
    lowest.disc(ahead * p.pivot_x_m, p.pivot_z_m, p.pivot_radius_m);
    lowest.disc(ahead * (p.pivot_x_m + p.flipper_m * f.cos), p.pivot_z_m + p.flipper_m * f.sin,
                p.tip_radius_m);
  }
  return lowest.best;
}

double pivot_on_run(const Support& support, double nose_up_rad, double curvature_rad_m) {
  if (std::fabs(curvature_rad_m) < 1e-6) return 0.0;
  return support.x_m + rt::sincos(nose_up_rad).sin / curvature_rad_m;
}

double edge_height_m(const TrackProfile& p, const Support& support, double x_m, double nose_up_rad) {
  const rt::SinCos d = rt::sincos(nose_up_rad);
  return support.height_m + x_m * d.sin + p.run_m() * d.cos;
}

double balance_on_run_m(const TrackProfile& p, double nose_up_rad) {
  const rt::SinCos d = rt::sincos(std::clamp(nose_up_rad, -kSteepest_rad, kSteepest_rad));
  const double x = p.com_x_m - (p.com_z_m - p.run_m()) * d.sin / d.cos;
  return std::clamp(x, -p.half_length_m, p.half_length_m);
}

}  // namespace sortie::estimators
