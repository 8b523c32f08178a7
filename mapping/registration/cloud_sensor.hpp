// SPDX-License-Identifier: BSD-3-Clause
// By what a cloud was seen, and the settings that suit it.
#pragma once

#include <cstdint>

#include "mapping/registration/plane_growing.hpp"
#include "mapping/registration/sight_layer.hpp"

namespace sortie::mapping {

/// What the points of a cloud come from. The numbers stand in files.
enum class CloudSensor : std::uint8_t {
  laser = 0,   ///< noise of some cm, whatever the range
  camera = 1,  ///< noise of about 1 % of the range
};

/// Settings of a cloud's cells. A camera's are as large as 1 % of the usual range needs, to tell flat from
/// thick.
inline SightConfig sight_config(CloudSensor sensor) {
  SightConfig config;
  if (sensor == CloudSensor::laser) return config;
  config.cell_m = 0.6;
  config.min_points = 12;
  config.most_thickness_m = 0.12;
  return config;
}

/// Settings of the growing of planes over these cells, whose normals point to where they were seen from. For
/// a layer with another edge set its `cell_m`.
inline PlaneGrowingConfig growing_config(CloudSensor sensor) {
  PlaneGrowingConfig config;
  config.cell_m = sight_config(sensor).cell_m;
  config.signed_normals = true;
  if (sensor == CloudSensor::laser) return config;
  config.most_angle_rad = 0.21;
  config.most_offset_m = 0.1;
  config.most_thickness_m = 0.12;
  config.most_flatness = 0.25;
  config.min_points = 12;
  config.most_weight = 64;
  return config;
}

}  // namespace sortie::mapping
