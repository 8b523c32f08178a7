// SPDX-License-Identifier: BSD-3-Clause
// A map as planes: at most 256 of them, in one frame.
#pragma once

#include "mapping/registration/plane.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::mapping {

/// Most planes of a set.
inline constexpr std::uint32_t kMostPlanes = 256;

/// Planes of one map, all in one frame whose z axis points up where gravity is known. 54 kB.
using PlaneSet = rt::FixedVector<Plane, kMostPlanes>;

/// `ok`, or what is wrong with the first plane that is not good; its place goes to `at`.
inline Status check(const PlaneSet& planes, std::uint32_t& at) {
  for (at = 0; at < planes.size(); ++at) {
    const Status status = check(planes[at]);
    if (status != Status::ok) return status;
  }
  return Status::ok;
}

}  // namespace sortie::mapping
