// SPDX-License-Identifier: BSD-3-Clause
// A tracked plant on a scene, driven by ramped belt speeds: what the plant's tests share.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>

#include "hil/plant/obstacles.hpp"
#include "hil/plant/tracked_plant.hpp"

namespace sortie::hil {

/// Scene, plant and a clock.
struct PlantBench {
  explicit PlantBench(const PlantConfig& plant_config = {}, double step_s = 1e-3,
                      const std::function<void(PlantScene&)>& build = on_plane,
                      ContactSolver solver = solve_contacts)
      : scene(std::make_unique<PlantScene>()), config(plant_config), dt_s(step_s) {
    build(*scene);
    plant = std::make_unique<TrackedPlant>(config, *scene, solver);
    for (int f = 0; f < kFlippers; ++f) command.flipper_rad[f] = config.start_flipper_rad[f];
  }

  static void on_plane(PlantScene& scene) {
    REQUIRE(scene.add_half_space({0, 0, 1}, {0, 0, 0}) == Status::ok);
  }

  void step(double left_m_s, double right_m_s) {
    command.left_m_s = left_m_s;
    command.right_m_s = right_m_s;
    REQUIRE(plant->step(command, dt_s) == Status::ok);
    const Quat& q = plant->state().q_world_body;
    const double yaw = std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
    yaw_rad += std::remainder(yaw - yaw_rad, 2.0 * 3.14159265358979323846);
  }

  /// Drives for `seconds` with a speed that rises at `ramp_m_s2` (the faster belt) and is held; the mean of
  /// each step.
  void drive(double left_m_s, double right_m_s, double seconds, double ramp_m_s2,
             const std::function<void()>& each = {}) {
    const double rise_s = std::max(std::fabs(left_m_s), std::fabs(right_m_s)) / ramp_m_s2;
    const long steps = std::lround(seconds / dt_s);
    for (long i = 0; i < steps; ++i) {
      const double share = ramp_integral((static_cast<double>(i) + 1.0) * dt_s, rise_s) -
                           ramp_integral(static_cast<double>(i) * dt_s, rise_s);
      step(left_m_s * share / dt_s, right_m_s * share / dt_s);
      if (each) each();
    }
  }

  /// Time that counts after `t` of a ramp from 0 to 1 in `rise_s`: the closed form of the distance at
  /// speed 1.
  static double ramp_integral(double t_s, double rise_s) {
    return t_s < rise_s ? 0.5 * t_s * t_s / rise_s : t_s - 0.5 * rise_s;
  }

  Vec3 position() const { return plant->p_world_body_m(); }
  double pitch() const {
    const Quat& q = plant->state().q_world_body;
    return std::asin(std::clamp(2.0 * (q.w * q.y - q.z * q.x), -1.0, 1.0));
  }

  double roll() const {
    const Quat& q = plant->state().q_world_body;
    return std::atan2(2.0 * (q.w * q.x + q.y * q.z), 1.0 - 2.0 * (q.x * q.x + q.y * q.y));
  }

  std::unique_ptr<PlantScene> scene;
  PlantConfig config;
  std::unique_ptr<TrackedPlant> plant;
  PlantCommand command;
  double dt_s;
  double yaw_rad{};
};

}  // namespace sortie::hil
