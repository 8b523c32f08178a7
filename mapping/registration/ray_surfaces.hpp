// SPDX-License-Identifier: BSD-3-Clause
// The flat surfaces of a map along a ray.
#pragma once

#include <cmath>

#include "mapping/registration/surfel_layer.hpp"

namespace sortie::mapping {

/// Least cosine between a ray and a normal: what grazes a surface does not tell that it goes through.
inline constexpr double kGrazingSurface = 0.25;

/// Looks at each half cell of a ray between two ranges, and at both sides of what is there. `stops(surfel,
/// range_m, off)` is asked of each thin surface: where the ray meets its plane, and how far from the
/// surface's middle. True with the first that stops it; false at the map's end, too. `ray`: unit vector in
/// the layer's frame. A look-up each half cell.
template <typename Stops>
bool meets_surface(const SurfelLayer& layer, const rt::Vector3& from, const rt::Vector3& ray, double near_m,
                   double far_m, Stops stops) {
  const double cell = layer.cell_m();
  const double thin = kThinSurface * cell;
  SurfelPlace place;
  for (double s = near_m; s < far_m; s += 0.5 * cell) {
    const rt::Vector3 p = from + s * ray;
    if (!layer.place(p.x, p.y, p.z, place)) return false;
    for (SurfelIndex at = layer.find(place.cell); at != kNoSurfel; at = layer.other_side(at)) {
      const Surfel& surfel = layer.surfel(at);
      if (surfel.count == 0 || surfel.variance(0) > thin * thin) continue;
      const rt::Vector3 n = surfel.normal();
      const double slope = rt::dot(n, ray);
      if (std::fabs(slope) < kGrazingSurface) continue;
      const rt::Vector3 mean = layer.centre_m(place.cell) + surfel.mean();
      const double range_m = rt::dot(n, mean - from) / slope;
      if (stops(surfel, range_m, from + range_m * ray - mean)) return true;
    }
  }
  return false;
}

}  // namespace sortie::mapping
