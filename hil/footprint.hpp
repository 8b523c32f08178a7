// SPDX-License-Identifier: BSD-3-Clause
// The outline of a robot or a piece of furniture, and whether it touches a solid.
#pragma once

#include "hil/solid.hpp"

namespace sortie::hil {

/// An upright prism on a turned rectangle: the outline of a robot.
struct Footprint {
  double center_x_m{};
  double center_y_m{};
  double cos_yaw{1};
  double sin_yaw{};
  double half_x_m{};
  double half_y_m{};
  double bottom_m{};
  double top_m{};
};

/// True if the prism and the solid share inner points. Separating axes for boxes, nearest point for
/// cylinders; wedges and tilted solids count as their upright bounding boxes.
bool overlaps(const Footprint& prism, const Solid& solid);

}  // namespace sortie::hil
