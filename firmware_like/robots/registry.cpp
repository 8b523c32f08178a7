// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/robots/registry.hpp"

#include "firmware_like/robots/uav.hpp"
#include "firmware_like/robots/ugv.hpp"
#include "firmware_like/scene/scene_parts.hpp"

namespace sortie::firmware {

namespace {

template <class Own>
std::unique_ptr<Vehicle> make(VehicleBuilder& builder) {
  refuse_unbuilt_parts(builder.profile());
  return std::make_unique<Own>(builder);
}

[[maybe_unused]] std::unique_ptr<Vehicle> refuse(VehicleBuilder& builder) {
  const Profile& profile = builder.profile();
  profile.fail("scene.vehicle", not_in_this_build("vehicle " + profile.vehicle(), profile.name()));
}

}  // namespace

VehicleRegistry own_vehicles() {
  VehicleRegistry vehicles;
  // A vehicle that is not in this build is known by its name, so that its scenes and logs get the cure.
  if constexpr (rt::kBuilt<rt::Part::ugv>) {
    vehicles.emplace_back("ugv", make<Ugv>);
  } else {
    vehicles.emplace_back("ugv", refuse);
  }
  if constexpr (rt::kBuilt<rt::Part::uav>) {
    vehicles.emplace_back("uav", make<Uav>);
  } else {
    vehicles.emplace_back("uav", refuse);
  }
  return vehicles;
}

}  // namespace sortie::firmware
