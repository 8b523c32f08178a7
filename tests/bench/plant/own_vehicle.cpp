// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <stdexcept>
#include <string>

#include "tests/bench/plant/bench_vehicle.hpp"

namespace sortie::bench {

OwnVehicle::OwnVehicle(const BenchScene& scene, int newton_iterations)
    : scene_(std::make_unique<hil::PlantScene>()) {
  scene.build(*scene_);
  hil::PlantConfig config;
  config.vehicle.friction = scene.friction;
  config.newton_iterations = newton_iterations;
  config.start_m = scene.start.p_world_m;
  config.start_q_world_body = scene.start.q_world_body;
  std::copy_n(scene.flipper_rad, hil::kFlippers, config.start_flipper_rad);
  std::copy_n(scene.flipper_rad, hil::kFlippers, command_.flipper_rad);
  plant_ = std::make_unique<hil::TrackedPlant>(config, *scene_);
}

void OwnVehicle::step(const BeltSpeeds& belts, double dt_s) {
  command_.left_m_s = belts.left_m_s;
  command_.right_m_s = belts.right_m_s;
  if (plant_->step(command_, dt_s) != Status::ok) throw std::runtime_error("the plant refused a step");
}

BenchPose OwnVehicle::pose() const { return {plant_->p_world_body_m(), plant_->state().q_world_body}; }

}  // namespace sortie::bench
