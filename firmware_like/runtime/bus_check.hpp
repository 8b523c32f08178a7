// SPDX-License-Identifier: BSD-3-Clause
// How full the CAN bus of a scene is at worst, from what its vehicle declares, before anything runs.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "drivers/can_load.hpp"
#include "firmware_like/scene/profile.hpp"

namespace sortie::firmware {

class Json;

/// The frames and what becomes of them; `load` has the same order.
struct BusCheck {
  std::uint32_t bitrate{};
  std::vector<drivers::CanStream> frames;
  drivers::CanLoad load;
};

/// Reads can.bitrate and works out load and worst responses. A frame that may still wait when the next of its
/// kind is due is a warning. Throws ProfileError, with the cure, where the bus cannot carry what is declared.
/// Nothing is read where there are no frames.
BusCheck check_bus(Profile& profile, const std::vector<drivers::CanStream>& frames,
                   std::vector<std::string>& warnings);

/// A table, the most urgent frame first; nothing without frames.
void print_bus(std::ostream& out, const BusCheck& bus);
Json to_json(const BusCheck& bus);

}  // namespace sortie::firmware
