// SPDX-License-Identifier: BSD-3-Clause
// The part of [hil] that describes the errors of the simulated IMU and encoders.
#pragma once

#include "firmware_like/scene/profile.hpp"
#include "hil/ugv_config.hpp"

namespace sortie::toolchain {

/// Reads rates, noise, ranges, stamps' errors and losses of IMU and encoders. Throws ProfileError.
void read_inertial(firmware::Profile& profile, hil::UgvConfig& config);
/// The IMU's part of that.
void read_imu_alone(firmware::Profile& profile, hil::ImuConfig& imu, hil::FaultConfig& faults);

}  // namespace sortie::toolchain
