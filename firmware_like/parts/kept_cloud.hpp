// SPDX-License-Identifier: BSD-3-Clause
// A kept cloud and the scene that is to be placed on it.
#pragma once

#include <memory>

#include "firmware_like/runtime/vehicle_builder.hpp"
#include "mapping/registration/cloud_match.hpp"

namespace sortie::firmware {

/// A cloud that was read, with what owns it.
struct KeptCloud {
  std::unique_ptr<mapping::SightLayer> layer;  ///< null: the run begins without one
  mapping::CloudSensor sensor{};
};

/// The cloud that the run begins with. Reads join.map and join.map_digest, in which `--map` has written which
/// one it is. Throws ProfileError where the profile names a map that is not there, or another one;
/// InputError, naming the cure, where the file is none.
KeptCloud load_kept_cloud(VehicleBuilder& builder);

}  // namespace sortie::firmware
