// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/street_course.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

namespace sortie::bench {
namespace {

/// Headings along the way, over a metre to either side.
void set_headings(StreetCourse& course) {
  std::vector<CoursePose>& poses = course.poses;
  const auto reach = static_cast<std::size_t>(std::lround(1.0 / course.step_m));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const CoursePose& from = poses[i > reach ? i - reach : 0];
    const CoursePose& to = poses[std::min(i + reach, poses.size() - 1)];
    poses[i].heading = std::atan2(to.y - from.y, to.x - from.x);
  }
}

}  // namespace

StreetCourse read_course(const std::string& path, double step_m, double most_m) {
  StreetCourse course;
  course.step_m = step_m;
  std::ifstream file(path);
  std::string line;
  bool has_one = false;
  double last_x = 0.0, last_y = 0.0, way_m = 0.0, next_m = 0.0;
  while (next_m <= most_m && std::getline(file, line)) {
    std::istringstream words(line);
    double index = 0.0, x = 0.0, y = 0.0;
    if (!(words >> index >> x >> y)) continue;
    const double part_m = has_one ? std::hypot(x - last_x, y - last_y) : 0.0;
    for (; has_one && next_m <= std::min(way_m + part_m, most_m); next_m += step_m) {
      const double share = part_m > 0.0 ? (next_m - way_m) / part_m : 0.0;
      course.poses.push_back({last_x + share * (x - last_x), last_y + share * (y - last_y), 0.0});
    }
    way_m += part_m;
    last_x = x;
    last_y = y;
    has_one = true;
  }
  set_headings(course);
  return course;
}

StreetCourse there_and_back(const StreetCourse& course, double out_m, double beside_m) {
  const auto count = std::min(course.poses.size(), static_cast<std::size_t>(out_m / course.step_m));
  StreetCourse both{course.step_m, {course.poses.begin(), course.poses.begin() + static_cast<long>(count)}};
  for (std::size_t i = count; i-- > 0;) {
    const CoursePose& out = course.poses[i];
    both.poses.push_back({out.x - beside_m * std::sin(out.heading), out.y + beside_m * std::cos(out.heading),
                          out.heading + M_PI});
  }
  return both;
}

std::vector<double> distance_to_left(const StreetCourse& course, double left_m) {
  const auto left = static_cast<std::size_t>(left_m / course.step_m);
  std::vector<double> distance(course.poses.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = left; i < course.poses.size(); ++i) {
    for (std::size_t k = 0; k + left < i; ++k) {
      const CoursePose &a = course.poses[i], &b = course.poses[k];
      distance[i] = std::min(distance[i], std::hypot(a.x - b.x, a.y - b.y));
    }
  }
  return distance;
}

}  // namespace sortie::bench
