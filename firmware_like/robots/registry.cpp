// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/robots/registry.hpp"

#include "firmware_like/parts/flight_part.hpp"
#include "firmware_like/robots/robot.hpp"
#include "firmware_like/scene/scene_parts.hpp"

namespace sortie::firmware {

namespace {

// A vehicle that is not in this build is known by its name, so that its scenes and logs get the cure.
template <rt::PartName vehicle, Robot::Maker core>
std::unique_ptr<Vehicle> make(VehicleBuilder& builder) {
  const Profile& profile = builder.profile();
  if constexpr (rt::kBuilt<vehicle>) {
    refuse_unbuilt_parts(profile);
    return std::make_unique<Robot>(builder, core);
  } else {
    profile.fail("scene.vehicle", not_in_this_build("vehicle " + profile.vehicle(), profile.name()));
  }
}

}  // namespace

VehicleRegistry own_vehicles() { return {{"ugv", make<"ugv", nullptr>}, {"uav", make<"uav", make_flight>}}; }

}  // namespace sortie::firmware
