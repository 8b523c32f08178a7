// SPDX-License-Identifier: BSD-3-Clause
// Random ground of boxes, ramps, steps and rails, built once for the plant and once as cells; and the plant
// put down on it until it rests: what a posture is judged by.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "hil/plant/tracked_plant.hpp"
#include "hil/random.hpp"
#include "planner/posture.hpp"

namespace sortie::planner {

/// A box that lies, tilts or stands on the plane z = 0.
struct CourseBox {
  hil::Vec3 centre_m;
  hil::Quat q_world_box;
  hil::Vec3 half_m;
};

/// Exact ground: the plane z = 0 and boxes on it.
struct BoxCourse {
  std::vector<CourseBox> boxes;
  double cell_m{0.05};

  /// Height of the uppermost surface at a place.
  double height(double x, double y) const {
    double top = 0.0;
    for (const CourseBox& box : boxes) {
      const hil::Quat back = hil::conjugate(box.q_world_box);
      const hil::Vec3 from = hil::rotate(back, hil::Vec3{x, y, 10.0} - box.centre_m);
      const hil::Vec3 down = hil::rotate(back, {0, 0, -1});
      const double start[3] = {from.x, from.y, from.z}, step[3] = {down.x, down.y, down.z};
      const double half[3] = {box.half_m.x, box.half_m.y, box.half_m.z};
      double in = 0.0, out = 20.0;
      for (int k = 0; k < 3; ++k) {
        if (std::fabs(step[k]) < 1e-12) {
          if (std::fabs(start[k]) > half[k]) out = -1.0;
          continue;
        }
        const double a = (-half[k] - start[k]) / step[k], b = (half[k] - start[k]) / step[k];
        in = std::max(in, std::min(a, b));
        out = std::min(out, std::max(a, b));
      }
      if (in <= out) top = std::max(top, 10.0 - in);
    }
    return top;
  }

  /// Least and most height in a cell, of 4 x 4 places: what a perfect map would hold.
  static GroundCell cell(const void* course, std::int64_t i, std::int64_t j) {
    const auto& self = *static_cast<const BoxCourse*>(course);
    double low = 1e9, high = -1e9;
    for (int k = 0; k < 16; ++k) {
      const double h = self.height((static_cast<double>(i) + 0.125 + 0.25 * (k % 4)) * self.cell_m,
                                   (static_cast<double>(j) + 0.125 + 0.25 * (k / 4)) * self.cell_m);
      low = std::min(low, h);
      high = std::max(high, h);
    }
    return {low, high, GroundState::known};
  }

  GroundView view() const { return {this, &BoxCourse::cell, cell_m}; }

  void build(hil::PlantScene& scene) const {
    (void)scene.add_half_space({0, 0, 1}, {0, 0, 0});
    for (const CourseBox& box : boxes) (void)scene.add_box(box.centre_m, box.q_world_box, box.half_m);
  }
};

/// What lies under the vehicle.
enum class CourseFamily { boxes, ramp, step, single_step, rail };
inline constexpr CourseFamily kCourseFamilies[] = {CourseFamily::boxes, CourseFamily::ramp,
                                                   CourseFamily::step, CourseFamily::single_step,
                                                   CourseFamily::rail};
inline constexpr const char* kCourseNames[] = {"boxes", "ramp", "step", "single-sided step", "rail"};

inline BoxCourse random_course(CourseFamily family, hil::Random& random) {
  BoxCourse course;
  const auto block = [&](double x, double y, double z, double yaw, double half_x, double half_y,
                         double half_z) {
    course.boxes.push_back({{x, y, z}, hil::from_yaw_pitch_roll(yaw, 0, 0), {half_x, half_y, half_z}});
  };
  const double turn = random.uniform(-3.14, 3.14);
  const double height = random.uniform(0.04, 0.25);
  switch (family) {
    case CourseFamily::boxes:
      for (int k = 0; k < 12; ++k) {
        const double x = random.uniform(-0.6, 0.6), y = random.uniform(-0.6, 0.6);
        const double half_x = random.uniform(0.06, 0.2), half_y = random.uniform(0.06, 0.2);
        const double half_z = random.uniform(0.02, 0.1);
        block(x, y, half_z, random.uniform(-3.14, 3.14), half_x, half_y, half_z);
      }
      break;
    case CourseFamily::ramp: {
      const double slope = random.uniform(0.05, 0.5);
      const hil::Quat tilt = hil::from_yaw_pitch_roll(turn, -slope, 0);
      const double x = random.uniform(-0.3, 0.3), y = random.uniform(-0.3, 0.3);
      // Its upper face goes through (x, y, 0) and rises along `turn`.
      const hil::Vec3 centre = hil::Vec3{x, y, 0} + hil::rotate(tilt, {1.5, 0, -0.5});
      course.boxes.push_back({centre, tilt, {1.5, 1.5, 0.5}});
      break;
    }
    case CourseFamily::step: {
      const double off = random.uniform(-0.4, 0.4);
      block((2.0 + off) * std::cos(turn), (2.0 + off) * std::sin(turn), 0.5 * height, turn, 2.0, 3.0,
            0.5 * height);
      break;
    }
    case CourseFamily::single_step:
      block(0.5 * std::cos(turn), 0.5 * std::sin(turn), 0.5 * height, turn, random.uniform(0.15, 0.45), 0.4,
            0.5 * height);
      break;
    case CourseFamily::rail: {
      const double off = random.uniform(-0.2, 0.2);
      block(off * std::cos(turn), off * std::sin(turn), 0.5 * height, turn, random.uniform(0.03, 0.08), 2.0,
            0.5 * height);
      break;
    }
  }
  return course;
}

/// The course with every upright box turned along the world's axes and its edges moved to the cells' borders:
/// cells lose nothing of it. Ramps stay as they are.
inline BoxCourse on_borders(BoxCourse course) {
  for (CourseBox& box : course.boxes) {
    if (std::fabs(box.q_world_box.x) + std::fabs(box.q_world_box.y) > 1e-9) continue;
    double* centre[2] = {&box.centre_m.x, &box.centre_m.y};
    double* half[2] = {&box.half_m.x, &box.half_m.y};
    for (int k = 0; k < 2; ++k) {
      const double low = course.cell_m * std::round((*centre[k] - *half[k]) / course.cell_m);
      const double high = low + course.cell_m * std::max(1.0, std::round(2.0 * *half[k] / course.cell_m));
      *centre[k] = 0.5 * (low + high);
      *half[k] = 0.5 * (high - low);
    }
    box.q_world_box = {};
  }
  return course;
}

/// The plant's vehicle as a posture has it: the same numbers.
inline PostureVehicle posture_vehicle(const hil::VehicleConfig& c) {
  PostureVehicle v;
  v.side.half_length_m = c.track_half_length_m;
  v.side.axle_m = c.track_centre_m.z;
  v.side.radius_m = c.track_radius_m;
  v.side.half_width_m = c.track_centre_m.y;
  v.side.pivot_x_m = c.flipper_pivot_m.x;
  v.side.pivot_z_m = c.flipper_pivot_m.z;
  v.side.pivot_radius_m = c.flipper_large_radius_m;
  v.side.flipper_m = c.flipper_length_m;
  v.side.tip_radius_m = c.flipper_small_radius_m;
  v.track_width_m = c.track_width_m;
  v.flipper_y_m = c.flipper_pivot_m.y;
  v.flipper_width_m = c.flipper_width_m;
  v.belly_rear_m = c.body_centre_m.x - c.body_half_m.x;
  v.belly_front_m = c.body_centre_m.x + c.body_half_m.x;
  v.belly_z_m = c.body_centre_m.z - c.body_half_m.z;
  v.belly_half_width_m = c.body_half_m.y;
  v.flipper_mass_kg = c.flipper_mass_kg;
  v.flipper_com_m = c.flipper_com_m;
  v.mass_kg = c.body_mass_kg + 2.0 * c.track_mass_kg + 4.0 * c.flipper_mass_kg;
  v.side.com_x_m =
      (c.body_mass_kg * c.body_centre_m.x + 2.0 * c.track_mass_kg * c.track_centre_m.x) / v.mass_kg;
  v.side.com_z_m = (c.body_mass_kg * c.body_centre_m.z + 2.0 * c.track_mass_kg * c.track_centre_m.z +
                    4.0 * c.flipper_mass_kg * c.flipper_pivot_m.z) /
                   v.mass_kg;
  return v;
}

/// A plant that was put down and has come to rest, or not.
struct PlantRest {
  bool rests{};
  GroundPose pose;
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

}  // namespace sortie::planner
