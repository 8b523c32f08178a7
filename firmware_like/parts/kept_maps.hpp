// SPDX-License-Identifier: BSD-3-Clause
// The kept map that a run begins with, for the part that reads it. Both readers read TABLE.map and
// TABLE.map_digest ("locate", "join"), in which `--map` has written which map it is. They throw ProfileError
// where the profile names a map that is not there, or another one; InputError, naming the cure, where the
// file is none or does not fit.
#pragma once

#include <memory>

#include "firmware_like/runtime/vehicle_builder.hpp"
#include "mapping/registration/cloud_match.hpp"
#include "mapping/registration/locator.hpp"

namespace sortie::firmware {

/// Gives the locator the map of surfaces that the run begins with, if the builder has one.
void load_kept_map(VehicleBuilder& builder, mapping::Locator& locator);

/// A cloud that was read, with what owns it.
struct KeptCloud {
  std::unique_ptr<mapping::SightLayer> layer;  ///< null: the run begins without one
  mapping::CloudSensor sensor{};
};

/// The cloud that the run begins with.
KeptCloud load_kept_cloud(VehicleBuilder& builder);

}  // namespace sortie::firmware
