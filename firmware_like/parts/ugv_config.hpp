// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's part of a scene profile: every key with unit, range, default and meaning.
#pragma once

#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "firmware_like/runtime/vehicle_builder.hpp"

namespace sortie::firmware {

/// Readers of [attitude] and [odometry]. Throw ProfileError.
estimators::AttitudeConfig read_attitude_config(VehicleBuilder& builder);
estimators::TrackOdometryConfig read_odometry_config(VehicleBuilder& builder);

}  // namespace sortie::firmware
