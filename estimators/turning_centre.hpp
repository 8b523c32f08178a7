// SPDX-License-Identifier: BSD-3-Clause
// About which point a skid-steered vehicle turns: it lies where half of the load is ahead and half behind.
#pragma once

#include <cmath>

#include "estimators/obstacle_geometry.hpp"

namespace sortie::estimators {

/// Forward coordinate x_v of the tracks' turning centres (ICR; Martinez et al. 2005), in body axes, m, of a
/// vehicle that turns slowly on a plane. Friction across the tracks has one size per load and points away
/// from the turning centre on both sides of it; without an outer force across, both sides carry equal loads:
/// x_v is the median of the load. On a straight run of half length a the pressure is p(x) = (1 + 3 c x / a^2)
/// / (2 a) with its centroid c under the centre of mass, and the median is the root of 3 c m^2 + 2 a^2 m = 3
/// c a^2. Beyond |c| = a / 3 the run lifts off at one end; there the limit holds. Cost: a root.
inline double turning_centre_x_m(const TrackProfile& profile) {
  const double a = profile.half_length_m;
  const double most = a / 3.0;
  const double c = profile.com_x_m < -most ? -most : profile.com_x_m > most ? most : profile.com_x_m;
  // Of 3 c m^2 + 2 a^2 m - 3 c a^2 = 0 the root near 0, in the form that does not cancel.
  return 3.0 * c * a * a / (a * a + std::sqrt(a * a * a * a + 9.0 * c * c * a * a));
}

}  // namespace sortie::estimators
