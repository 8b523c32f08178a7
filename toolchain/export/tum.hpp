// SPDX-License-Identifier: BSD-3-Clause
// Trajectories for evo and the RPG tools.
#pragma once

#include <iosfwd>
#include <span>

#include "firmware_like/log/timed_pose.hpp"

namespace sortie::toolchain {

/// One line a pose: `t tx ty tz qx qy qz qw`, t in seconds with nine decimals (exact), the rest as short as a
/// double reads back the same. Returns the lines written.
std::size_t write_tum(std::ostream& out, std::span<const firmware::TimedPose> trajectory);

}  // namespace sortie::toolchain
