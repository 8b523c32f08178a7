// SPDX-License-Identifier: BSD-3-Clause
// The CAN bus of a scene, checked when it is loaded: worst-case load and response time of each frame.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "drivers/can_load.hpp"
#include "firmware_like/profile.hpp"

namespace sortie::firmware {

/// What was computed. Without frames: the vehicle has no bus.
struct BusLoad {
  std::uint32_t bitrate{};
  double max_share{};  ///< allowed
  std::vector<drivers::CanStream> streams;
  drivers::CanLoad load;
};

/// Reads [can] (bitrate, max_load_percent, and the frames of other devices, [[can.frames]]) and works out the
/// bus with all of it. ProfileError where the load is above its limit, and for a frame that may take longer
/// than until the next of its kind: the newer one would not find the older one gone.
BusLoad check_bus(Profile& profile, std::vector<drivers::CanStream> streams);

/// One line a frame, the most urgent first; nothing without frames.
void print_bus(std::ostream& out, const BusLoad& bus);
nlohmann::ordered_json to_json(const BusLoad& bus);

}  // namespace sortie::firmware
