// SPDX-License-Identifier: BSD-3-Clause
// Random ground of boxes, ramps, steps and rails, built once for the plant and once as cells.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "hil/plant/plant_scene.hpp"
#include "hil/plant/vehicle_config.hpp"
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
  static HeightCell cell(const void* course, std::int64_t i, std::int64_t j) {
    const auto& self = *static_cast<const BoxCourse*>(course);
    double low = 1e9, high = -1e9;
    for (int k = 0; k < 16; ++k) {
      const double h = self.height((static_cast<double>(i) + 0.125 + 0.25 * (k % 4)) * self.cell_m,
                                   (static_cast<double>(j) + 0.125 + 0.25 * (k / 4)) * self.cell_m);
      low = std::min(low, h);
      high = std::max(high, h);
    }
    return {low, high, HeightState::known};
  }

  HeightView view() const { return {this, &BoxCourse::cell, cell_m}; }

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

}  // namespace sortie::planner
