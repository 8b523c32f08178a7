// SPDX-License-Identifier: BSD-3-Clause
// A bounded piece of plane with what is known about its errors: what maps of different sensors have in
// common when their points have not; and a map as such planes.
#pragma once

#include <cmath>
#include <cstdint>

#include "rt/describe.hpp"
#include "rt/fixed_vector.hpp"
#include "rt/rotation.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// A rectangle in a plane, in the frame of its set. Points x of the plane have normal . x = offset_m. The
/// rectangle's sides lie along axis_u and axis_v = normal x axis_u, the directions of most and least spread
/// of what it was fitted to. Errors are those of the fit: about these axes, and at this centroid, they are
/// independent of each other, so that three numbers are the whole covariance (K. Pathak et al. 2010).
struct Plane {
  rt::Vector3 normal{0, 0, 1};  ///< unit; to the side that it was seen from, where that is known
  double offset_m{};            ///< normal . centroid
  rt::Vector3 centroid_m;       ///< mean of its points
  rt::Vector3 axis_u{1, 0, 0};  ///< unit, in the plane
  double least_m[2]{};          ///< the rectangle's lower sides along u and v, from the centroid; <= 0
  double most_m[2]{};           ///< its upper sides; >= 0
  double area_m2{};             ///< of what was seen, at most the rectangle's
  double sigma_offset_m{0.01};  ///< standard deviation along the normal, at the centroid
  double sigma_tilt_rad[2]{};   ///< of the turn about u, and about v
  std::uint32_t id{};           ///< its owner's name for it
  SORTIE_FIELDS(normal, offset_m, centroid_m, axis_u, least_m, most_m, area_m2, sigma_offset_m,
                sigma_tilt_rad, id)

  constexpr rt::Vector3 axis_v() const { return rt::cross(normal, axis_u); }
};

/// The 4x4 information of (normal, offset) as a measurement of one plane: the inverse of the covariance that
/// small turns about u and v and a shift along the normal at the centroid give. Row-major, symmetric, rank 3
/// (length of the normal carries none).
struct PlaneInformation {
  double m[16]{};
};

/// Sum of r r^T / sigma^2 of the three independent errors: the turn about u moves the normal along -v, the
/// turn about v moves it along u; the offset that belongs to a normal is the one through the centroid.
inline PlaneInformation information_of(const Plane& plane) {
  const rt::Vector3 u = plane.axis_u;
  const rt::Vector3 v = plane.axis_v();
  const double rows[3][4] = {{v.x, v.y, v.z, 0},
                             {u.x, u.y, u.z, 0},
                             {-plane.centroid_m.x, -plane.centroid_m.y, -plane.centroid_m.z, 1}};
  const double sigma[3] = {plane.sigma_tilt_rad[0], plane.sigma_tilt_rad[1], plane.sigma_offset_m};
  PlaneInformation information;
  for (int k = 0; k < 3; ++k) {
    const double weight = 1.0 / (sigma[k] * sigma[k]);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) information.m[4 * i + j] += weight * rows[k][i] * rows[k][j];
    }
  }
  return information;
}

/// Furthest coordinate of a plane [m], largest area [m2], and the range of its standard deviations that can
/// be computed with (they are used squared).
inline constexpr double kMostPlaneCoordinate_m = 1e6;
inline constexpr double kMostPlaneArea_m2 = 1e8;
inline constexpr double kLeastPlaneSigma = 1e-9;
inline constexpr double kMostPlaneSigma = 1e6;

/// `not_finite` where anything is a NaN or an infinity; `out_of_range` where axes are not unit or not square
/// to each other (1e-6), the centroid is not on the plane (1e-6 of its distance, 1 um), sides are on the
/// wrong side, or anything is beyond the limits above. Cost: about 40 operations.
inline Status check(const Plane& p) {
  const double numbers[] = {p.offset_m,       p.least_m[0],        p.least_m[1],
                            p.most_m[0],      p.most_m[1],         p.area_m2,
                            p.sigma_offset_m, p.sigma_tilt_rad[0], p.sigma_tilt_rad[1]};
  bool finite = rt::is_finite(p.normal) && rt::is_finite(p.centroid_m) && rt::is_finite(p.axis_u);
  for (const double number : numbers) finite = finite && std::isfinite(number);
  if (!finite) return Status::not_finite;
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  const auto unit = [&](const rt::Vector3& a) { return within(rt::dot(a, a), 1.0 - 2e-6, 1.0 + 2e-6); };
  const auto inside = [&](double value) {
    return within(value, -kMostPlaneCoordinate_m, kMostPlaneCoordinate_m);
  };
  bool good = unit(p.normal) && unit(p.axis_u) && within(rt::dot(p.normal, p.axis_u), -1e-6, 1e-6);
  good = good && inside(p.centroid_m.x) && inside(p.centroid_m.y) && inside(p.centroid_m.z);
  good = good &&
         std::fabs(rt::dot(p.normal, p.centroid_m) - p.offset_m) <= 1e-6 * (1.0 + rt::norm(p.centroid_m));
  for (int k = 0; k < 2; ++k) {
    good = good && within(p.least_m[k], -kMostPlaneCoordinate_m, 0.0) &&
           within(p.most_m[k], 0.0, kMostPlaneCoordinate_m) &&
           within(p.sigma_tilt_rad[k], kLeastPlaneSigma, kMostPlaneSigma);
  }
  good = good && within(p.area_m2, 0.0, kMostPlaneArea_m2) &&
         within(p.sigma_offset_m, kLeastPlaneSigma, kMostPlaneSigma);
  return good ? Status::ok : Status::out_of_range;
}

/// Most planes of a set.
inline constexpr std::uint32_t kMostPlanes = 256;

/// Planes of one map, all in one frame whose z axis points up where gravity is known. 39 kB.
using PlaneSet = rt::FixedVector<Plane, kMostPlanes>;

/// `ok`, or what is wrong with the first plane that is not good; its place goes to `at`.
inline Status check(const PlaneSet& planes, std::uint32_t& at) {
  for (at = 0; at < planes.size(); ++at) {
    const Status status = check(planes[at]);
    if (status != Status::ok) return status;
  }
  return Status::ok;
}

}  // namespace sortie::mapping
