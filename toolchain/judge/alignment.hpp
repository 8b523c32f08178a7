// SPDX-License-Identifier: BSD-3-Clause
// Least-squares alignment of an estimate to its truth (Umeyama 1991, without scale), as evo does it.
#pragma once

#include <string_view>

#include "toolchain/judge/trajectory.hpp"

namespace sortie::toolchain {

/// What is allowed to move before errors are taken.
enum class Alignment {
  none,   ///< the frames are the same
  first,  ///< the first estimate is laid on the first truth (turned, too, where the truth has an orientation)
  se2,    ///< heading and position: x, y, yaw, and the mean height where the truth has one
  se3,    ///< all six
};

/// The alignment of this name. Throws std::invalid_argument that lists the names.
Alignment parse_alignment(std::string_view name);

/// The name of an alignment, as parse_alignment takes it.
const char* to_string(Alignment alignment);

/// A rotation (row-major) and a translation: p_new = r * p + t.
struct RigidTransform {
  double r[9]{1, 0, 0, 0, 1, 0, 0, 0, 1};
  double t[3]{};
};

/// The transform that lays the estimate on the truth. Uses pairs whose truth has a position; with none of
/// them (or for Alignment::none) the identity. For se2 and se3 two pairs are the least; with fewer only the
/// position is moved.
RigidTransform find_alignment(const PairedTrajectories& pairs, Alignment alignment);

/// Moves every pose by `transform`.
void move_by(const RigidTransform& transform, firmware::Trajectory& trajectory);

}  // namespace sortie::toolchain
