// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/vehicles/registry.hpp"

#include "firmware_like/scene_parts.hpp"
#include "firmware_like/vehicles/uav.hpp"
#include "firmware_like/vehicles/ugv.hpp"

namespace sortie::firmware {

namespace {

template <class Own>
std::unique_ptr<Vehicle> make(VehicleBuilder& builder) {
  refuse_unbuilt_parts(builder.profile());
  return std::make_unique<Own>(builder);
}

}  // namespace

VehicleRegistry own_vehicles() {
  VehicleRegistry vehicles;
  if constexpr (rt::kBuilt<rt::Part::ugv>) vehicles.emplace_back("ugv", make<Ugv>);
  if constexpr (rt::kBuilt<rt::Part::uav>) vehicles.emplace_back("uav", make<Uav>);
  return vehicles;
}

}  // namespace sortie::firmware
