// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/robots/registry.hpp"

#include "firmware_like/parts/flight_part.hpp"
#include "firmware_like/robots/robot.hpp"
#include "firmware_like/scene/scene_parts.hpp"

namespace sortie::firmware {

namespace {

std::unique_ptr<Vehicle> make(VehicleBuilder& builder, Robot::Maker core) {
  refuse_unbuilt_parts(builder.profile());
  return std::make_unique<Robot>(builder, core);
}

[[maybe_unused]] std::unique_ptr<Vehicle> refuse(VehicleBuilder& builder) {
  const Profile& profile = builder.profile();
  profile.fail("scene.vehicle", not_in_this_build("vehicle " + profile.vehicle(), profile.name()));
}

}  // namespace

VehicleRegistry own_vehicles() {
  VehicleRegistry vehicles;
  // A vehicle that is not in this build is known by its name, so that its scenes and logs get the cure.
  if constexpr (rt::kBuilt<"ugv">) {
    vehicles.emplace_back("ugv", [](VehicleBuilder& builder) { return make(builder, nullptr); });
  } else {
    vehicles.emplace_back("ugv", refuse);
  }
  if constexpr (rt::kBuilt<"uav">) {
    vehicles.emplace_back("uav", [](VehicleBuilder& builder) { return make(builder, make_flight); });
  } else {
    vehicles.emplace_back("uav", refuse);
  }
  return vehicles;
}

}  // namespace sortie::firmware
