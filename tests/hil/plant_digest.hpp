// SPDX-License-Identifier: BSD-3-Clause
// A fixed drive of the tracked plant, as one number.
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>

#include "hil/plant/obstacles.hpp"
#include "hil/plant/tracked_plant.hpp"
#include "rt/digest.hpp"

namespace sortie::hil {

/// Digest of the states of a drive of 3 s on `stairs` (csm, through libccd) or on a plane alone (belts,
/// turning).
inline std::uint64_t drive_digest(bool stairs) {
  const auto scene = std::make_unique<PlantScene>();
  static_cast<void>(scene->add_half_space({0, 0, 1}, {0, 0, 0}));
  if (stairs) static_cast<void>(add_stairs(*scene, {{0.6, 0, 0}, 0.1}, {}));
  PlantConfig config;
  config.vehicle.mode = stairs ? ContactMode::csm : ContactMode::belt;
  config.vehicle.friction = 1.0;
  const auto plant = std::make_unique<TrackedPlant>(config, *scene);
  PlantCommand command;
  std::uint64_t chain = 0;
  for (std::uint64_t i = 0; i < 1500; ++i) {
    const double share = i < 200 ? static_cast<double>(i) / 200.0 : 1.0;
    command.left_m_s = (stairs ? 0.3 : -0.1) * share;
    command.right_m_s = 0.3 * share;
    command.flipper_rad[0] = command.flipper_rad[1] = i < 700 ? 0.6 : -0.2;
    if (plant->step(command, 2e-3) != Status::ok) return 0;
    const PlantState& s = plant->state();
    const double numbers[13] = {s.com_world_m.x,
                                s.com_world_m.y,
                                s.com_world_m.z,
                                s.q_world_body.w,
                                s.q_world_body.x,
                                s.q_world_body.y,
                                s.q_world_body.z,
                                s.velocity.linear.x,
                                s.velocity.linear.y,
                                s.velocity.angular.z,
                                plant->flipper_torque_nm(0),
                                s.flipper_rad[2],
                                plant->report().kinetic_j};
    std::uint8_t bytes[sizeof(numbers)];
    std::memcpy(bytes, numbers, sizeof(numbers));
    chain = rt::chain_digest(chain, i, rt::digest_bytes(bytes, sizeof(bytes)));
  }
  return chain;
}

}  // namespace sortie::hil
