// SPDX-License-Identifier: BSD-3-Clause
#include "hil/plant/scene_world.hpp"

namespace sortie::hil {
namespace {

Vec3 to_vec3(const rt::Vector3& v) { return {v.x, v.y, v.z}; }

// A solid from the body's own rotation matrix, not from a quaternion that would round anew.
Status to_solid(const rt::convex::Convex& body, std::uint16_t reflectivity, Solid& solid) {
  const Vec3 center = to_vec3(body.p_world_m);
  const double* m = body.R_world_body.m;
  const Axes axes{{m[0], m[3], m[6]}, {m[1], m[4], m[7]}, {m[2], m[5], m[8]}};
  if (body.kind == rt::convex::Kind::box) {
    solid = make_tilted_box(center, axes, to_vec3(body.half_m), reflectivity);
    return Status::ok;
  }
  if (body.kind != rt::convex::Kind::track || body.length_m != 0.0) return Status::not_supported;
  solid = make_tilted_cylinder(center, axes, body.radius_m[0], body.half_m.y, reflectivity);
  return Status::ok;
}

}  // namespace

Status add_to_world(const PlantScene& scene, World& world, std::uint16_t reflectivity) {
  for (const PlantScene::Solid& entry : scene.solids()) {
    Solid solid;
    if (const Status status = to_solid(entry.shape, reflectivity, solid); status != Status::ok) return status;
    if (const Status status = world.add(solid); status != Status::ok) return status;
  }
  return Status::ok;
}

}  // namespace sortie::hil
