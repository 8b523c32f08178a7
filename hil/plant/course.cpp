// SPDX-License-Identifier: BSD-3-Clause
#include "hil/plant/course.hpp"

#include <stdexcept>
#include <string>

#include "hil/plant/scene_world.hpp"

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

}  // namespace

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
