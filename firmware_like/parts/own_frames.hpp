// SPDX-License-Identifier: BSD-3-Clause
// The robot's own frames (drivers/dbc/robot.dbc) as a scene puts them on the bus, for the check of its load.
#pragma once

#include <cstdint>
#include <span>

#include "firmware_like/runtime/vehicle_builder.hpp"

namespace sortie::firmware {

/// Frames that are sent together. `queue`: as of CanStream; 0: by the runtime, through one interface.
void add_own_frames(VehicleBuilder& builder, std::span<const std::uint32_t> ids, rt::Nanoseconds period_ns,
                    int queue = 0);

/// Frames of a device that sends them together; how often is `key` of the profile, in Hz.
void add_device_frames(VehicleBuilder& builder, std::span<const std::uint32_t> ids, const char* key,
                       double usual_hz, const char* device);

}  // namespace sortie::firmware
