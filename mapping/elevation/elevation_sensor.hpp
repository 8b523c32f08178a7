// SPDX-License-Identifier: BSD-3-Clause
// Where a sensor is in the window of the elevation map, in the map's units.
#pragma once

#include <cstdint>

#include "mapping/elevation/elevation_map.hpp"

namespace sortie::mapping {

struct ElevationMap::Sensor {
  std::int32_t along[2]{};  ///< from the window's low corner, kGroundUnits
  std::int32_t height{};    ///< kHeightUnits above the level
};

}  // namespace sortie::mapping
