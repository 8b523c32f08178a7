// SPDX-License-Identifier: BSD-3-Clause
#include "hil/plant/course.hpp"

#include <stdexcept>
#include <string>

namespace sortie::hil {
namespace {

Status add(const CoursePiece& piece, std::uint64_t seed, PlantScene& scene) {
  const Approach where{{piece.x_m, piece.y_m, 0.0}, piece.yaw_rad};
  const Quat heading = from_yaw_pitch_roll(piece.yaw_rad, 0.0, 0.0);
  const auto count = static_cast<int>(piece.count);
  switch (piece.kind) {
    case CourseKind::stairs:
      return add_stairs(scene, where, {count, piece.run_m, piece.height_m, piece.width_m, piece.length_m});
    case CourseKind::pallet:
      return add_pallet(scene, where);
    case CourseKind::ramp:
      return add_ramp(scene, where, piece.slope_rad, piece.length_m, piece.deck_m, piece.width_m);
    case CourseKind::rubble:
      return add_rubble(scene, where, piece.length_m, piece.width_m, count, seed);
    case CourseKind::cylinder:  // lies across the way, half sunk into the ground
      return scene.add_cylinder(where.p_world_m, heading, piece.height_m, 0.5 * piece.width_m);
    case CourseKind::wall:
      return scene.add_box(
          where.p_world_m + rotate(heading, {0.5 * piece.length_m, 0.0, 0.5 * piece.height_m}), heading,
          {0.5 * piece.length_m, 0.5 * piece.width_m, 0.5 * piece.height_m});
  }
  return Status::not_supported;
}

std::string why(Status status) {
  if (status == Status::full) return "the course has too many solids; leave pieces or rubble out";
  if (status == Status::not_finite) return "its place and sizes must be finite";
  return "its sizes must be above 0";
}

Vec3 to_vec3(const rt::Vector3& v) { return {v.x, v.y, v.z}; }

// A solid from the body's own rotation matrix, not from a quaternion that would round anew.
Status to_solid(const rt::convex::Convex& body, Solid& solid) {
  const Vec3 center = to_vec3(body.p_world_m);
  const double* m = body.R_world_body.m;
  const Axes axes{{m[0], m[3], m[6]}, {m[1], m[4], m[7]}, {m[2], m[5], m[8]}};
  if (body.kind == rt::convex::Kind::box) {
    solid = make_tilted_box(center, axes, to_vec3(body.half_m));
    return Status::ok;
  }
  if (body.kind != rt::convex::Kind::track || body.length_m != 0.0) return Status::not_supported;
  solid = make_tilted_cylinder(center, axes, body.radius_m[0], body.half_m.y);
  return Status::ok;
}

}  // namespace

Status add_to_world(const PlantScene& scene, World& world) {
  for (const PlantScene::Solid& entry : scene.solids()) {
    Solid solid;
    if (const Status status = to_solid(entry.shape, solid); status != Status::ok) return status;
    if (const Status status = world.add(solid); status != Status::ok) return status;
  }
  return Status::ok;
}

void build_course(const CourseConfig& config, PlantScene& scene, World& world) {
  const auto must = [](Status status, const std::string& what) {
    if (status != Status::ok) throw std::runtime_error("hil course: " + what + ": " + why(status));
  };
  must(scene.add_half_space({0, 0, 1}, {0, 0, 0}), "the ground");
  for (std::size_t i = 0; i < config.pieces.size(); ++i)
    must(add(config.pieces[i], config.seed + i, scene), "row " + std::to_string(i));
  must(add_to_world(scene, world), "the world");
  must(world.finalize(), "the world");
}

}  // namespace sortie::hil
