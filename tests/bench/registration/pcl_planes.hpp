// SPDX-License-Identifier: BSD-3-Clause
// Planes of a cloud by PCL: normals of neighbours, regions grown over them.
#pragma once

#include <span>
#include <vector>

#include "rt/rotation.hpp"

namespace sortie::bench {

/// A plane of a region: its middle and its normal, of either sign.
struct RegionPlane {
  rt::Vector3 middle_m;
  rt::Vector3 normal;
};

/// Normals of 20 neighbours, regions of 100 points and more over 20 neighbours, 5 degrees, curvature 0.05;
/// one thread. `ms`: of the thread. Empty where PCL is not there.
std::vector<RegionPlane> pcl_planes(std::span<const rt::Vector3> points_m, double& ms);

}  // namespace sortie::bench
