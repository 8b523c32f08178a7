// SPDX-License-Identifier: BSD-3-Clause
// The modules' programs, by the file that they stand in. What each tries is told in modules.cpp.
#pragma once

#include "tests/bench/campaign/campaign.hpp"

namespace sortie::bench {

// rt_trials.cpp
CampaignOutcome run_math_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_queue_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_stamp_trial(std::span<const CampaignOp> ops);

// estimator_trials.cpp
CampaignOutcome run_attitude_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_odometry_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_uav_state_trial(std::span<const CampaignOp> ops);

// mapping_trials.cpp
CampaignOutcome run_grid_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_ray_trial(std::span<const CampaignOp> ops);

// planner_trials.cpp
CampaignOutcome run_path_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_drive_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_flight_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_riccati_trial(std::span<const CampaignOp> ops);

// plant_trials.cpp
CampaignOutcome run_tracked_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_multirotor_trial(std::span<const CampaignOp> ops);

// wire_trials.cpp
CampaignOutcome run_wire_trial(std::span<const CampaignOp> ops);
CampaignOutcome run_can_trial(std::span<const CampaignOp> ops);

// runtime_trials.cpp
CampaignOutcome run_runtime_trial(std::span<const CampaignOp> ops);

}  // namespace sortie::bench
