// SPDX-License-Identifier: BSD-3-Clause
// The map's part of the ground robot's profile: every key with unit, range, default and meaning.
#pragma once

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/parts/sensor_mount.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "mapping/grid/sweep.hpp"

namespace sortie::firmware {

/// Map, its pools, what sweeps are, and where the lidar sits.
struct UgvMapConfig {
  ChosenMapConfig map;
  mapping::SweepConfig sweep;
  std::uint32_t scan_buffers{};
  bool publish{};   ///< lists of segments
  bool features{};  ///< in them
  bool anytime{};   ///< the segmenter stops when the task's units are spent
};

/// Reads [lidar], [outline] and the keys of [map] that say how sweeps are straightened; ranges are not set.
/// Throws ProfileError.
mapping::SweepConfig read_sweep_config(Profile& profile);

/// Reads [map], [lidar], [outline] and the map's [limits]. Throws ProfileError, also for settings that do not
/// fit one another.
UgvMapConfig read_map_config(Profile& profile);

}  // namespace sortie::firmware
