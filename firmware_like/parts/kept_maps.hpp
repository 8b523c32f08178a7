// SPDX-License-Identifier: BSD-3-Clause
// The kept maps that a run begins with, for the parts that read them. All readers read TABLE.map and
// TABLE.map_digest ("locate", "join", "recognise", "recognise_images"), in which `--map`, `--targets` or
// `--images` has written which one it is. They throw ProfileError where the profile names a map that is not
// there, or another one; InputError, naming the cure, where the file is none or does not fit.
#pragma once

#include <memory>

#include "firmware_like/runtime/vehicle_builder.hpp"
#include "mapping/recognition/image_store.hpp"
#include "mapping/recognition/target_store.hpp"
#include "mapping/registration/cloud_match.hpp"
#include "mapping/registration/locator.hpp"

namespace sortie::firmware {

/// Gives the locator the map of surfaces that the run begins with, if the builder has one.
void load_kept_map(VehicleBuilder& builder, mapping::Locator& locator);

/// Targets that the run begins with, in a store with just room for them, at rest; null: it begins without.
std::unique_ptr<mapping::TargetStore> load_kept_targets(VehicleBuilder& builder,
                                                        const mapping::TargetStoreConfig& config);

/// Height images that the run begins with, in a store with just room for them; null: it begins without.
std::unique_ptr<mapping::ImageStore> load_kept_images(VehicleBuilder& builder,
                                                      const mapping::ImageStoreConfig& config);

/// A cloud that was read, with what owns it.
struct KeptCloud {
  std::unique_ptr<mapping::SightLayer> layer;  ///< null: the run begins without one
  mapping::CloudSensor sensor{};
};

/// The cloud that the run begins with.
KeptCloud load_kept_cloud(VehicleBuilder& builder);

}  // namespace sortie::firmware
