// SPDX-License-Identifier: BSD-3-Clause
// By what a cloud was seen, the settings that suit it and those of the registration of two clouds, and what
// that says of a place.
#pragma once

#include <cstdint>

#include "mapping/registration/plane_growing.hpp"
#include "mapping/registration/plane_registration_config.hpp"
#include "mapping/registration/sight_score.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"

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

/// What became of a registration.
enum class CloudVerdict : std::uint8_t {
  none,       ///< not begun
  working,    ///< units ran out; run() goes on
  placed,     ///< in all directions
  refused,    ///< see CloudRefusal
  ambiguous,  ///< another place explains as much
};

/// Why.
enum class CloudRefusal : std::uint8_t {
  none,
  no_place,  ///< planes lead nowhere
  little,    ///< too few cells lie on surfaces
  crossed,   ///< lines of sight go through surfaces
  scale,     ///< farther from the estimate's than that allows
  unheld,    ///< a direction, or an axis, that too little holds
  rival,     ///< another place is nearly as good
  turn,  ///< no yaw is known, and planes alone do not place it there: a hall may look the same from both ends
  mirrored,  ///< the mirror image is: another wing, another building
  alone,     ///< cells of no other grid have it as their best place, too (CloudMatch)
};

/// The names as they are shown.
const char* to_string(CloudVerdict verdict);
const char* to_string(CloudRefusal refusal);

/// A place, and what speaks for it. Good to use where the verdict is `placed`.
struct CloudResult {
  CloudVerdict verdict{CloudVerdict::none};
  CloudRefusal refusal{CloudRefusal::none};
  PlanePose T_target_source;  ///< of the best place, also where it is refused
  double sigma_m{};           ///< of the middle of the source, in the direction held least
  double sigma_rad{};
  std::uint32_t cells{};    ///< of both clouds
  std::uint32_t on{};       ///< of them on surfaces of the other cloud
  std::uint32_t through{};  ///< of them seen through surfaces of the other cloud
  double lead{};      ///< what speaks for this place alone over what speaks for another one alone; the least
  PlanePose T_rival;  ///< that place
  bool rival_mirrored{};    ///< it is one of the source's mirror image
  std::uint32_t places{};   ///< that were looked at from near
  std::uint32_t dropped{};  ///< other places that there was no room for: then it is ambiguous
  std::uint32_t fits{};
  std::uint32_t looks{};  ///< poses at which all cells were looked at
  std::uint64_t units{};  ///< of work done
  SORTIE_FIELDS(verdict, refusal, T_target_source, sigma_m, sigma_rad, cells, on, through, lead, T_rival,
                rival_mirrored, places, dropped, fits, looks, units)

  bool placed() const { return verdict == CloudVerdict::placed; }
};

/// When a place is believed. Give it a yaw (a compass to some degrees is enough): without one only what
/// planes alone place is placed, at the same place.
struct CloudRegistrationConfig {
  PlaneRegistrationConfig planes;
  SightGates gates;
  std::uint32_t starts{6};     ///< of the planes' places, most evidence first, that are looked at
  std::uint32_t least_on{40};  ///< cells on surfaces of the other cloud
  double most_through{0.015};  ///< of the cells, through surfaces of the other cloud
  double most_sigma_m{0.05};
  double most_sigma_rad{0.005};
  double least_lead{1.5};  ///< CloudResult::lead

  SORTIE_KEYS(c, key) {
    key("starts", c.starts, {1, 8, "places", "that planes lead to and that are looked at"});
    key("most_through", c.most_through, {0, 1, "", "of the cells, that may be seen through surfaces"});
    key("most_sigma_m", c.most_sigma_m, {0.001, 1, "m", "of the position, where it is held least"});
    key("most_sigma_deg", c.most_sigma_rad,
        {0.01, 10, rt::kDegInRad, "of the turn, about the axis that is held least"});
    key("least_lead", c.least_lead, {1, 100, "", "what speaks for a place over what speaks for another"});
  }
};

/// How often CloudMatch asks.
struct CloudMatchConfig {
  static constexpr std::uint32_t kMostGrids = 8;
  CloudRegistrationConfig registration;
  std::uint32_t grids{3};  ///< of cells twice as wide, that are asked as well

  SORTIE_KEYS(c, key) {
    key("wider_grids", c.grids,
        {0, kMostGrids, "grids",
         "of wider cells that are asked as well, until two agree; 0: none, and none need to"});
  }
};

}  // namespace sortie::mapping
