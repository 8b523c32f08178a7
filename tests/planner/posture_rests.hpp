// SPDX-License-Identifier: BSD-3-Clause
// The plant put down on a course until it rests, and a posture beside it: what postures are judged by.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "hil/plant/tracked_plant.hpp"
#include "tests/planner/posture_courses.hpp"

namespace sortie::planner {

/// A plant that was put down and has come to rest, or not.
struct PlantRest {
  bool rests{};
  StandPose pose;
  FlipperSet flippers;
  double pitch_rad{}, roll_rad{}, height_m{};
  double seconds{};
};

/// Puts the plant down level at `height_m` and waits until nothing moves for 0.2 s, at most 6 s.
inline PlantRest put_down(const BoxCourse& course, const FlipperSet& flippers, double yaw_rad,
                          double height_m, double friction) {
  constexpr double kStep_s = 2e-3;
  const auto scene = std::make_unique<hil::PlantScene>();
  course.build(*scene);
  hil::PlantConfig config;
  config.vehicle.friction = friction;
  config.start_m = {0, 0, height_m};
  config.start_q_world_body = hil::from_yaw_pitch_roll(yaw_rad, 0, 0);
  hil::PlantCommand command;
  for (int f = 0; f < 4; ++f) command.flipper_rad[f] = config.start_flipper_rad[f] = flippers.angle_rad[f];
  const auto plant = std::make_unique<hil::TrackedPlant>(config, *scene);
  PlantRest rest;
  int still = 0;
  for (int k = 0; k < 3000 && still < 100; ++k) {
    if (plant->step(command, kStep_s) != Status::ok) return rest;
    const hil::Generalised& u = plant->state().velocity;
    const bool slow = hil::norm(u.linear) < 5e-4 && hil::norm(u.angular) < 1e-3;
    still = slow && k > 100 ? still + 1 : 0;
    rest.seconds = k * kStep_s;
  }
  rest.rests = still >= 100;
  const hil::Quat& q = plant->state().q_world_body;
  const rt::Quaternion turned{q.w, q.x, q.y, q.z};
  rest.pitch_rad = rt::pitch_of(turned);
  rest.roll_rad = rt::roll_of(turned);
  const hil::Vec3 p = plant->p_world_body_m();
  rest.pose = {p.x, p.y, rt::yaw_of(turned)};
  rest.height_m = p.z;
  for (int f = 0; f < 4; ++f) rest.flippers.angle_rad[f] = plant->state().flipper_rad[f];
  return rest;
}

/// A posture beside the plant's rest at the place where the plant came to it. Angles in rad.
struct RestError {
  bool rests{};       ///< the plant did; else nothing below is said
  Rest told{};        ///< by the posture
  double tilt_rad{};  ///< larger one of pitch and roll
  double height_m{};
  bool other_rest{};  ///< more than 2 degrees off, and a posture that starts at the plant's tilt stays there
  bool near_edge{};   ///< more than 2 degrees off, and at the plant's own tilt the centre of mass lies within
                      ///< 1.5 samples of the edge of what is within 5 mm of touching
  double plant_s{};
};

/// The margin of a vehicle that is held at a tilt, of all that is within 5 mm of touching; m.
inline double margin_at(const PostureVehicle& vehicle, const BoxCourse& course, const PlantRest& plant) {
  const auto ground = std::make_unique<GroundPatch>();
  const auto lifts = std::make_unique<Lifts>();
  PostureConfig config;
  config.touch_m = 0.005;
  if (ground->fill(course.view(), plant.pose, config.ground) != Status::ok) return 1.0;
  const Tilt tilt(plant.pitch_rad, plant.roll_rad);
  const Outline outline = outline_of(vehicle, plant.flippers);
  (void)lifts_at(outline, *ground, tilt, *lifts);
  Posture held;
  if (lifts->empty()) return 1.0;
  weigh_support(config, outline, *lifts, tilt.turn(centre_of_mass(vehicle, plant.flippers)), vehicle.mass_kg,
                held);
  return held.margin_m;
}

/// One trial: a random course, flippers and heading by `seed`.
inline RestError rest_beside_plant(PostureSolver& solver, CourseFamily family, std::uint64_t seed,
                                   bool borders, double cell_m) {
  constexpr double kApart_rad = 0.035;
  hil::Random random(seed, 0x72657374 + static_cast<std::uint64_t>(family));
  BoxCourse course = random_course(family, random);
  course.cell_m = cell_m;
  if (borders) course = on_borders(course);
  FlipperSet flippers;
  for (double& angle : flippers.angle_rad) angle = random.uniform(-0.6, 1.2);
  const double yaw = random.uniform(-3.1, 3.1);
  double top = 0.0;
  for (int i = -16; i <= 16; ++i)
    for (int j = -16; j <= 16; ++j) top = std::max(top, course.height(0.05 * i, 0.05 * j));
  RestError error;
  Posture start;
  if (solver.look(course.view(), {0, 0, yaw}) != Status::ok || solver.rest(flippers, start) != Status::ok)
    return error;
  const PlantRest plant = put_down(course, flippers, yaw, std::min(top + 0.5, start.height_m + 0.15), 0.9);
  error.plant_s = plant.seconds;
  Posture posture, there;
  if (!plant.rests || solver.look(course.view(), plant.pose) != Status::ok ||
      solver.rest(plant.flippers, posture) != Status::ok)
    return error;
  error.rests = true;
  error.told = posture.rest;
  const auto apart = [&](const Posture& p) {
    return std::max(std::fabs(p.pitch_rad - plant.pitch_rad), std::fabs(p.roll_rad - plant.roll_rad));
  };
  error.tilt_rad = apart(posture);
  error.height_m = std::fabs(posture.height_m - plant.height_m);
  if (error.tilt_rad > kApart_rad && std::max(std::fabs(plant.pitch_rad), std::fabs(plant.roll_rad)) < 1.2 &&
      solver.rest(plant.flippers, {plant.pitch_rad, plant.roll_rad}, there) == Status::ok)
    error.other_rest = apart(there) <= kApart_rad;
  if (error.tilt_rad > kApart_rad && !error.other_rest) {
    const double margin = margin_at(solver.vehicle(), course, plant);
    // 0: two contacts or fewer, which say nothing.
    error.near_edge = margin != 0.0 && std::fabs(margin) < 1.5 * solver.ground().spacing_m();
  }
  return error;
}

/// Errors of many trials. Tilts and heights are of those that rest, and not in another rest.
struct RestErrors {
  std::vector<double> tilt_deg, height_mm;
  int count{}, no_rest{}, other_rest{}, not_standing{}, off{}, near_edge{};

  void add(const RestError& e) {
    ++count;
    if (!e.rests) {
      ++no_rest;
      return;
    }
    if (e.told != Rest::stands) ++not_standing;
    if (e.other_rest) {
      ++other_rest;
      return;
    }
    tilt_deg.push_back(e.tilt_rad * 57.29577951);
    height_mm.push_back(1e3 * e.height_m);
    if (tilt_deg.back() <= 2.0) return;
    ++off;
    if (e.near_edge) ++near_edge;
  }

  static double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0.0
                          : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  }

  /// One line of it.
  std::string words(const char* name) const {
    char line[320];
    std::snprintf(
        line, sizeof line,
        "%-18s %5d poses, %d never at rest, %d another rest, %d not standing; tilt p50 %.2f p90 %.2f "
        "p99 %.2f deg, %d above 2 (%d near an edge); height p50 %.1f p90 %.1f p99 %.1f mm",
        name, count, no_rest, other_rest, not_standing, quantile(tilt_deg, 0.5), quantile(tilt_deg, 0.9),
        quantile(tilt_deg, 0.99), off, near_edge, quantile(height_mm, 0.5), quantile(height_mm, 0.9),
        quantile(height_mm, 0.99));
    return line;
  }
};

}  // namespace sortie::planner
