// SPDX-License-Identifier: BSD-3-Clause
// A pose as one in the plane, and what that leaves out.
#pragma once

#include <cmath>

#include "mapping/grid/rolling_grid_config.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// What a pose has beside x, y and yaw. A point of the sensor is turned by `tilt`, then by the yaw, then
/// moved.
struct OutOfPlane {
  double height_m{};
  rt::Quaternion tilt;
};

/// The turn about z in a rotation; none where it stands on its head.
inline rt::Quaternion upright_turn(const rt::Quaternion& q) {
  const double n = std::sqrt(q.w * q.w + q.z * q.z);
  return n > 1e-6 ? rt::Quaternion{q.w / n, 0.0, 0.0, q.z / n} : rt::Quaternion{};
}

/// x, y and yaw of a pose: height 0, no tilt.
inline RigidPose laid_flat(const RigidPose& pose) {
  return {{pose.p.x, pose.p.y, 0.0}, upright_turn(pose.q)};
}

/// What laid_flat() leaves out.
inline OutOfPlane out_of_plane(const RigidPose& pose) {
  return {pose.p.z, rt::normalised(rt::conjugate(upright_turn(pose.q)) * pose.q)};
}

/// Both together again.
inline RigidPose stood_up(const RigidPose& flat, const OutOfPlane& rest) {
  return {{flat.p.x, flat.p.y, rest.height_m}, rt::normalised(flat.q * rest.tilt)};
}

}  // namespace sortie::mapping
