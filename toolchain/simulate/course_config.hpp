// SPDX-License-Identifier: BSD-3-Clause
// The part of [hil] that makes the simulated robot one with contacts, on a course of obstacles.
#pragma once

#include "firmware_like/scene/profile.hpp"
#include "hil/ugv_config.hpp"

namespace sortie::toolchain {

/// Reads hil.contacts and what belongs to it into a config whose start pose and sensors are already there.
/// Throws ProfileError.
void read_course(firmware::Profile& profile, hil::UgvConfig& config);

}  // namespace sortie::toolchain
