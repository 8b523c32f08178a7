// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/elevation/veil.hpp"

#include <cmath>

#include "rt/rotation.hpp"

namespace sortie::mapping {

namespace {

constexpr double kNeighbour_sin2 = 6.85e-4;  // of 1.5 degrees

rt::Vector3 place_of(const rt::ScanPoint& point) {
  return {static_cast<double>(point.x_m), static_cast<double>(point.y_m), static_cast<double>(point.z_m)};
}

/// The way from one return to its neighbour runs along the beam. Squares, so that nothing is divided: the
/// tangent is what the way has across the near one's beam over what it has along it.
bool runs_along(const rt::Vector3& a, const rt::Vector3& b, double most_slope) {
  const double a2 = rt::dot(a, a);
  const double b2 = rt::dot(b, b);
  const double ab = rt::dot(a, b);
  const double sin2_ab = a2 * b2 - ab * ab;  // |a|^2 |b|^2 sin^2
  if (!(ab > 0.0) || !(sin2_ab <= kNeighbour_sin2 * a2 * b2)) return false;
  const double along = a2 - ab;  // times |a|
  return sin2_ab <= most_slope * most_slope * along * along;
}

}  // namespace

std::size_t without_veils(std::span<const rt::ScanPoint> points, double most_slope,
                          std::span<rt::ScanPoint> kept) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size() && count < kept.size(); ++i) {
    if (i > 0 && i + 1 < points.size()) {
      const rt::Vector3 before = place_of(points[i - 1]);
      const rt::Vector3 here = place_of(points[i]);
      const rt::Vector3 after = place_of(points[i + 1]);
      const double range2 = rt::dot(here, here);
      const bool is_between = (rt::dot(before, before) < range2) != (rt::dot(after, after) < range2);
      if (is_between && runs_along(here, before, most_slope) && runs_along(here, after, most_slope)) continue;
    }
    kept[count++] = points[i];
  }
  return count;
}

}  // namespace sortie::mapping
