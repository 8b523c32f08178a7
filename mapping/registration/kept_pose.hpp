// SPDX-License-Identifier: BSD-3-Clause
// Whether a pose that was read is one.
#pragma once

#include "mapping/grid/rolling_grid_config.hpp"
#include "rt/archive.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// A unit quaternion, to a hundredth, and no farther off than any map reaches.
inline bool is_pose(const RigidPose& pose) {
  constexpr double kFar_m = 1e9;
  const double square = rt::squared_norm(pose.q);
  return rt::dot(pose.p, pose.p) < kFar_m * kFar_m && square > 0.98 && square < 1.02;
}

/// Fails the archive where a pose that was read is none: the casts of those who use it rely on it.
inline void check_pose(rt::Archive& archive, const RigidPose& pose) {
  if (archive.is_reading() && !is_pose(pose)) archive.fail(Status::malformed, "a pose that is none");
}

}  // namespace sortie::mapping
