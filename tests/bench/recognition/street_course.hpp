// SPDX-License-Identifier: BSD-3-Clause
// Where somebody drove, as steps of a robot's way.
#pragma once

#include <string>
#include <vector>

#include "rt/rotation.hpp"

namespace sortie::bench {

/// A place on the ground and the direction of the way there, m and rad.
struct CoursePose {
  double x{};
  double y{};
  double heading{};
};

/// A way of equal steps.
struct StreetCourse {
  double step_m{};
  std::vector<CoursePose> poses;
  double way_m() const { return step_m * static_cast<double>(poses.size()); }
};

/// The first `most_m` of a recorded drive (index, x, y, z and a quaternion a line) from above, heights and
/// tilts left out. Empty where the file is not there.
StreetCourse read_course(const std::string& path, double step_m, double most_m);

/// The first `out_m` of a way, and back on the left side of the road, `beside_m` from the way out.
StreetCourse there_and_back(const StreetCourse& course, double out_m, double beside_m);

/// Of the places of a way that were left more than `left_m` of way before a pose, the nearest one's distance;
/// infinity where there is none. For all poses at once.
std::vector<double> distance_to_left(const StreetCourse& course, double left_m);

}  // namespace sortie::bench
