// SPDX-License-Identifier: BSD-3-Clause
// The plane that a rigid body comes down on: of the upper hull of lifts, the facet over the centre of mass.
#pragma once

#include <cmath>

#include "planner/posture_outline.hpp"

namespace sortie::planner {

/// A plane z = height + slope_x x + slope_y y about the centre of mass.
struct SupportPlane {
  double height_m{};
  double slope_x{};
  double slope_y{};
  bool carried{};  ///< by three samples around the centre of mass; false: it lies outside of all
};

/// The facet of the upper hull of (x, y, lift) over (com_x, com_y). A triangle around the centre of mass
/// starts far out and far down; the sample that lies highest above its plane takes the place of the corner
/// behind the centre of mass. The plane rises over the centre of mass each time, so that it ends. At most 24
/// exchanges, a pass over the lifts each.
inline SupportPlane support_plane(const Lifts& lifts, double com_x, double com_y) {
  constexpr int kMostExchanges = 24;
  constexpr double kFar_m = 10.0;
  constexpr double kDeep_m = -2e4;
  constexpr double kEven_m = 1e-9;
  // No sample lies on a line through the centre of mass and another one then.
  const double at_x = com_x + 1.2e-7;
  const double at_y = com_y + 0.9e-7;
  struct Corner {
    double x, y, z;
    bool real;
  };
  Corner corner[3] = {{kFar_m, 0.0, kDeep_m, false},
                      {-0.5 * kFar_m, 0.8 * kFar_m, kDeep_m, false},
                      {-0.5 * kFar_m, -0.8 * kFar_m, kDeep_m, false}};
  SupportPlane plane{kDeep_m, 0.0, 0.0, false};
  for (int exchange = 0; exchange < kMostExchanges; ++exchange) {
    double most = kEven_m;
    const Lift* highest = nullptr;
    for (const Lift& lift : lifts) {
      const double above = lift.lift_m - (plane.height_m + plane.slope_x * (lift.x_m - at_x) +
                                          plane.slope_y * (lift.y_m - at_y));
      if (above > most) {
        most = above;
        highest = &lift;
      }
    }
    if (highest == nullptr) break;
    const Corner added{highest->x_m - at_x, highest->y_m - at_y, highest->lift_m, true};
    // The edge that the ray from it through the centre of mass leaves by stays.
    for (int k = 0; k < 3; ++k) {
      const Corner& u = corner[k];
      const Corner& v = corner[(k + 1) % 3];
      if (u.y * added.x - u.x * added.y < 0.0 || v.x * added.y - v.y * added.x < 0.0) continue;
      corner[(k + 2) % 3] = added;
      break;
    }
    const Corner& a = corner[0];
    const double x1 = corner[1].x - a.x, y1 = corner[1].y - a.y, z1 = corner[1].z - a.z;
    const double x2 = corner[2].x - a.x, y2 = corner[2].y - a.y, z2 = corner[2].z - a.z;
    const double area = x1 * y2 - x2 * y1;
    if (!(std::fabs(area) > 1e-12)) break;
    plane.slope_x = (z1 * y2 - z2 * y1) / area;
    plane.slope_y = (x1 * z2 - x2 * z1) / area;
    plane.height_m = a.z - plane.slope_x * a.x - plane.slope_y * a.y;
  }
  plane.carried = corner[0].real && corner[1].real && corner[2].real;
  return plane;
}

}  // namespace sortie::planner
