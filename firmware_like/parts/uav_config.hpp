// SPDX-License-Identifier: BSD-3-Clause
// The multirotor's part of a scene profile: every key with unit, range, default and meaning.
#pragma once

#include <vector>

#include "estimators/uav_state/uav_estimator.hpp"
#include "firmware_like/parts/stored_cells.hpp"
#include "firmware_like/runtime/vehicle_builder.hpp"
#include "planner/uav_guide.hpp"
#include "planner/uav_pilot.hpp"

namespace sortie::firmware {

/// The map that ways are planned on, and the planner's pools.
struct GuideConfig {
  planner::FlightMapConfig map;
  bool sensed{};                 ///< by the lidar
  std::vector<CellState> known;  ///< what another run found out, a state a voxel; empty: nothing
  planner::SensedCells cells;
  double bubble_m{};  ///< taken for free around the vehicle's own size until the first question
  std::vector<planner::KnownBox> boxes;
  std::uint32_t parts{16'384};
  std::uint32_t voxels{16'384};
  std::uint32_t corners{4096};

  SORTIE_KEYS(c, key) {
    key("path_parts", c.parts, {256, 1 << 20, "", "connected parts of blocks that a search may meet"});
    key("path_voxels", c.voxels, {256, 1 << 20, "", "of the fine search; a power of two"});
    key("path_corners", c.corners,
        {planner::CornerMemory::kFewest, 1 << 20, "", "of a way before it is shortened"});
  }
};

/// Readers of [airframe] and [flight], [state], [mission], [flight_map] and [limits]. Throw ProfileError.
planner::UavPilotConfig read_pilot_config(VehicleBuilder& builder);
estimators::UavEstimatorConfig read_uav_estimator_config(VehicleBuilder& builder);
std::vector<planner::UavGoal> read_uav_mission(VehicleBuilder& builder);
std::vector<planner::UavGoal> read_uav_looks(VehicleBuilder& builder);
GuideConfig read_guide_config(VehicleBuilder& builder);
/// Of [flight_map] its voxels and what chances mean alone, as a map has them that is sensed or stored.
GuideConfig read_flight_voxels(Profile& profile);

}  // namespace sortie::firmware
