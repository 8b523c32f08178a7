// SPDX-License-Identifier: BSD-3-Clause
// located_t: where a robot is on its map. encode() and decode() are those of wire_fields.hpp; no heap.
#pragma once

#include "drivers/wire_fields.hpp"
#include "rt/located_pose.hpp"

namespace sortie::drivers {

template <>
struct WireRules<rt::LocatedPose> : WireNumbered {
  static bool taken(const rt::LocatedPose& pose) { return pose.weak_moves <= 3 && pose.weak_turns <= 3; }
};
inline constexpr std::size_t kLocatedBytes = kLeastBytes<rt::LocatedPose>;

}  // namespace sortie::drivers
