// SPDX-License-Identifier: BSD-3-Clause
// What a plumb line meets first.
#include "hil/plant/course_heights.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace sortie::hil {
namespace {

constexpr double kNothing = -std::numeric_limits<double>::infinity();
constexpr double kLevel = 1e-12;  ///< a direction whose rise is below does not rise

/// Top of a box over (x, y): each pair of faces holds the plumb line between two heights.
double top_of_box(const rt::convex::Convex& box, double x_m, double y_m) {
  const double* m = box.R_world_body.m;
  const double half[3] = {box.half_m.x, box.half_m.y, box.half_m.z};
  const double dx = x_m - box.p_world_m.x;
  const double dy = y_m - box.p_world_m.y;
  double low = kNothing;
  double high = -kNothing;
  for (int k = 0; k < 3; ++k) {
    const double rise = m[6 + k];
    const double along = m[k] * dx + m[3 + k] * dy;
    if (std::fabs(rise) < kLevel) {
      if (std::fabs(along) > half[k]) return kNothing;
      continue;
    }
    const double one = (half[k] - along) / rise;
    const double other = (-half[k] - along) / rise;
    low = std::max(low, std::min(one, other));
    high = std::min(high, std::max(one, other));
  }
  return low <= high ? box.p_world_m.z + high : kNothing;
}

/// Top of a cylinder that lies level.
double top_of_cylinder(const rt::convex::Convex& cylinder, double x_m, double y_m) {
  const double* m = cylinder.R_world_body.m;  // its axis is the second column
  if (std::fabs(m[7]) > kLevel)
    throw std::runtime_error("hil course: heights are of cylinders that lie level");
  const double dx = x_m - cylinder.p_world_m.x;
  const double dy = y_m - cylinder.p_world_m.y;
  const double along = m[1] * dx + m[4] * dy;
  const double across = m[4] * dx - m[1] * dy;
  const double under = cylinder.radius_m[0] * cylinder.radius_m[0] - across * across;
  if (std::fabs(along) > cylinder.half_m.y || under < 0.0) return kNothing;
  return cylinder.p_world_m.z + std::sqrt(under);
}

bool is_cylinder(const rt::convex::Convex& body) {
  return body.kind == rt::convex::Kind::track && body.length_m == 0.0;
}

/// The rotation seen in the mirror y -> -y.
Quat mirrored_rotation(const rt::convex::Convex& body) {
  const rt::Quaternion q = rt::from_matrix(body.R_world_body);
  return normalized({q.w, -q.x, q.y, -q.z});
}

}  // namespace

double upper_height(const PlantScene& scene, double x_m, double y_m) {
  double top = kNothing;
  for (const rt::convex::HalfSpace& ground : scene.half_spaces()) {
    const rt::Vector3& n = ground.normal;
    if (n.z > kLevel) top = std::max(top, (ground.offset_m - n.x * x_m - n.y * y_m) / n.z);
  }
  for (const PlantScene::Solid& solid : scene.solids()) {
    const rt::convex::Bounds& b = solid.bounds;
    if (x_m < b.low_m.x || x_m > b.high_m.x || y_m < b.low_m.y || y_m > b.high_m.y || b.high_m.z <= top)
      continue;
    if (solid.shape.kind == rt::convex::Kind::box)
      top = std::max(top, top_of_box(solid.shape, x_m, y_m));
    else if (is_cylinder(solid.shape))
      top = std::max(top, top_of_cylinder(solid.shape, x_m, y_m));
    else
      throw std::runtime_error("hil course: heights are of boxes and cylinders alone");
  }
  return top;
}

Status add_mirrored(const PlantScene& scene, PlantScene& out) {
  for (const rt::convex::HalfSpace& ground : scene.half_spaces()) {
    const Vec3 normal{ground.normal.x, -ground.normal.y, ground.normal.z};
    const Status status = out.add_half_space(normal, ground.offset_m * normal);
    if (status != Status::ok) return status;
  }
  for (const PlantScene::Solid& solid : scene.solids()) {
    const rt::convex::Convex& body = solid.shape;
    const Vec3 centre{body.p_world_m.x, -body.p_world_m.y, body.p_world_m.z};
    const Quat turned = mirrored_rotation(body);
    const Status status = is_cylinder(body)
                              ? out.add_cylinder(centre, turned, body.radius_m[0], body.half_m.y)
                              : out.add_box(centre, turned, {body.half_m.x, body.half_m.y, body.half_m.z});
    if (status != Status::ok) return status;
  }
  return Status::ok;
}

}  // namespace sortie::hil
