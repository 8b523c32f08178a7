// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/vehicles/registry.hpp"

#include "firmware_like/vehicles/uav.hpp"
#include "firmware_like/vehicles/ugv.hpp"

namespace sortie::firmware {

VehicleRegistry own_vehicles() {
  return {
      {"ugv",
       [](VehicleBuilder& builder) -> std::unique_ptr<Vehicle> { return std::make_unique<Ugv>(builder); }},
      {"uav",
       [](VehicleBuilder& builder) -> std::unique_ptr<Vehicle> { return std::make_unique<Uav>(builder); }}};
}

}  // namespace sortie::firmware
