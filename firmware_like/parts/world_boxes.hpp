// SPDX-License-Identifier: BSD-3-Clause
// The boxes of a scene: what the simulated world is built of, and what a vehicle's map knows of it.
#pragma once

#include <vector>

#include "firmware_like/scene/profile.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// An upright box.
struct WorldBox {
  double lowest_m[3]{};
  double highest_m[3]{};
  rt::Nanoseconds from_ns{};  ///< it is there from here on
};

/// Reads [[world.boxes]], sorted by the time from which they are there. Throws ProfileError.
std::vector<WorldBox> read_world_boxes(Profile& profile);

}  // namespace sortie::firmware
