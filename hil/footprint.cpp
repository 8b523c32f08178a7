// SPDX-License-Identifier: BSD-3-Clause
// Overlap of an outline and a solid in plan view and height.
#include "hil/footprint.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::hil {

bool overlaps(const Footprint& prism, const Solid& solid) {
  if (prism.top_m <= solid.bottom_m || prism.bottom_m >= solid.top_m) return false;
  const double dx = solid.center_x_m - prism.center_x_m;
  const double dy = solid.center_y_m - prism.center_y_m;
  // The solid's centre in the frame of the prism.
  const double px = std::fabs(prism.cos_yaw * dx + prism.sin_yaw * dy);
  const double py = std::fabs(prism.cos_yaw * dy - prism.sin_yaw * dx);
  if (solid.kind == SolidKind::cylinder) {
    const double gap_x = std::max(px - prism.half_x_m, 0.0);
    const double gap_y = std::max(py - prism.half_y_m, 0.0);
    return gap_x * gap_x + gap_y * gap_y < solid.half_x_m * solid.half_x_m;
  }
  const double c = std::fabs(prism.cos_yaw * solid.cos_yaw + prism.sin_yaw * solid.sin_yaw);
  const double s = std::fabs(prism.cos_yaw * solid.sin_yaw - prism.sin_yaw * solid.cos_yaw);
  const double ox = std::fabs(solid.cos_yaw * dx + solid.sin_yaw * dy);
  const double oy = std::fabs(solid.cos_yaw * dy - solid.sin_yaw * dx);
  return px < prism.half_x_m + c * solid.half_x_m + s * solid.half_y_m &&
         py < prism.half_y_m + s * solid.half_x_m + c * solid.half_y_m &&
         ox < solid.half_x_m + c * prism.half_x_m + s * prism.half_y_m &&
         oy < solid.half_y_m + s * prism.half_x_m + c * prism.half_y_m;
}

}  // namespace sortie::hil
