// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/modes/course_drive.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "hil/plant/tracked_plant.hpp"

namespace sortie::bench {
namespace {

constexpr double kStep_s = 0.002;
constexpr int kStepsPerSample = 5;
constexpr double kAcceleration_m_s2 = 0.5;
constexpr double kSettle_s = 1.0;
constexpr double kHalfSpan_m = 0.1985;

void take_contacts(const hil::TrackedPlant& plant, CourseSample& sample) {
  const auto& tags = plant.tags();
  const auto& contacts = plant.contacts();
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    const hil::ContactPoint& c = contacts[i];
    const double load = norm(c.impulse_ns) / kStep_s;
    if (load < 0.5) continue;
    const int part = tags[i].part;
    if (part == 0) {
      sample.belly_n += load;
      continue;
    }
    SideContacts& side = sample.side[hil::side_of(part) > 0 ? 0 : 1];
    side.load_n += load;
    if (side.rear_part < 0 || c.point_m.x < side.rear_x_m) {
      side.rear_part = part;
      side.rear_x_m = c.point_m.x;
      side.rear_z_m = c.point_m.z;
      side.rear_nx = c.normal.x;
      side.rear_nz = c.normal.z;
    }
    if (side.front_part < 0 || c.point_m.x > side.front_x_m) {
      side.front_part = part;
      side.front_x_m = c.point_m.x;
      side.front_z_m = c.point_m.z;
      side.front_nx = c.normal.x;
      side.front_nz = c.normal.z;
    }
  }
}

CourseSample look(const hil::TrackedPlant& plant, double t_s, const hil::Vec3& force_world_m_s2) {
  CourseSample s;
  const hil::PlantState& state = plant.state();
  s.t_s = t_s;
  s.left_m = state.left_m;
  s.right_m = state.right_m;
  s.q_world_body = state.q_world_body;
  s.w_body_rad_s = state.velocity.angular;
  s.force_m_s2 = hil::rotate(conjugate(state.q_world_body), force_world_m_s2);
  for (int f = 0; f < hil::kFlippers; ++f) {
    s.flipper_rad[f] = state.flipper_rad[f];
    s.flipper_rad_s[f] = state.velocity.joint[f];
  }
  s.p_world_m = plant.p_world_body_m();
  s.v_world_m_s = plant.velocity_world_m_s({});
  take_contacts(plant, s);
  return s;
}

}  // namespace

std::vector<CourseSample> drive_course(const CourseScene& scene, double speed_m_s, hil::ContactMode mode) {
  auto ground = std::make_unique<hil::PlantScene>();
  scene.build(*ground);
  hil::PlantConfig config;
  config.vehicle.mode = mode;
  config.vehicle.friction = scene.friction;
  config.start_m = scene.start_m;
  config.start_q_world_body = scene.start_q_world_body;
  std::copy_n(scene.flipper_rad, hil::kFlippers, config.start_flipper_rad);
  auto plant = std::make_unique<hil::TrackedPlant>(config, *ground);
  hil::PlantCommand command;
  std::copy_n(scene.flipper_rad, hil::kFlippers, command.flipper_rad);

  std::vector<CourseSample> samples;
  const double rise_s = speed_m_s / kAcceleration_m_s2;
  const double full_s = std::fabs(scene.way_m) / speed_m_s;  // the ramps' halves make up for each other
  const double end_s = kSettle_s + full_s + rise_s + 0.5;
  const double sign = scene.way_m < 0 ? -1.0 : 1.0;
  const double turn = scene.turn_rad_per_m * kHalfSpan_m;
  const long steps = std::lround(end_s / kStep_s);
  hil::Vec3 force_world_m_s2;
  for (long i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) * kStep_s - kSettle_s;
    if (i % kStepsPerSample == 0) {
      if (t >= -0.1) samples.push_back(look(*plant, t, force_world_m_s2));
      force_world_m_s2 = {};
    }
    const double share = std::clamp(std::min(t / rise_s, (full_s + rise_s - t) / rise_s), 0.0, 1.0);
    const double speed = sign * speed_m_s * share;
    command.left_m_s = speed * (1.0 - turn);
    command.right_m_s = speed * (1.0 + turn);
    if (plant->step(command, kStep_s) != Status::ok) throw std::runtime_error("the plant refused a step");
    force_world_m_s2 =
        force_world_m_s2 +
        (1.0 / kStepsPerSample) * hil::rotate(plant->state().q_world_body, plant->specific_force_m_s2({}));
  }
  return samples;
}

}  // namespace sortie::bench
