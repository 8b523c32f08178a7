// SPDX-License-Identifier: BSD-3-Clause
// Building a plant's scene: each refusal leaves it as it was.
#include "hil/plant/plant_scene.hpp"

#include <cmath>

namespace sortie::hil {

Status PlantScene::add_half_space(const Vec3& normal, const Vec3& point_m) {
  const double length = norm(normal);
  if (!is_finite(point_m) || !std::isfinite(length)) return Status::not_finite;
  if (!(length > 1e-12)) return Status::out_of_range;
  const Vec3 n = (1.0 / length) * normal;
  return half_spaces_.push_back({{n.x, n.y, n.z}, dot(n, point_m)}) ? Status::ok : Status::full;
}

Status PlantScene::add_box(const Vec3& centre_m, const Quat& q_world_box, const Vec3& half_m) {
  return add(rt::convex::make_box({half_m.x, half_m.y, half_m.z}), centre_m, q_world_box);
}

Status PlantScene::add_cylinder(const Vec3& centre_m, const Quat& q_world_cylinder, double radius_m,
                                double half_length_m) {
  return add(rt::convex::make_cylinder(radius_m, half_length_m), centre_m, q_world_cylinder);
}

Status PlantScene::add(rt::convex::Convex shape, const Vec3& centre_m, const Quat& q_world_shape) {
  const double length = dot(q_world_shape, q_world_shape);
  if (!is_finite(centre_m) || !std::isfinite(length)) return Status::not_finite;
  if (shape.kind == rt::convex::Kind::none || !(length > 1e-12)) return Status::out_of_range;
  const Quat q = normalized(q_world_shape);
  rt::convex::place(shape, {centre_m.x, centre_m.y, centre_m.z}, {q.w, q.x, q.y, q.z});
  return solids_.push_back({shape, rt::convex::bounds(shape)}) ? Status::ok : Status::full;
}

}  // namespace sortie::hil
