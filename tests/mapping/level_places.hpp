// SPDX-License-Identifier: BSD-3-Clause
// Things of a hall, and the level poses that lay a local map of them on a known one: for tests of
// recognition.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping/recognition/level_fit.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::testing {

/// To the nearest whole centimetre; m in.
inline mapping::PlaceCm rounded(const rt::Vector3& p) {
  const auto whole = [](double m) { return static_cast<std::int32_t>(std::floor(100.0 * m + 0.5)); };
  return {whole(p.x), whole(p.y), whole(p.z)};
}

/// A turn about the upright and a move, m.
struct LevelPose {
  double yaw{}, x{}, y{}, z{};
  rt::Vector3 operator()(const rt::Vector3& p) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {c * p.x - s * p.y + x, s * p.x + c * p.y + y, p.z + z};
  }
};

/// Any heading, within 80 m.
inline LevelPose any_level_pose(Draws& draws) {
  return {draws.uniform(-3, 3), draws.uniform(-80, 80), draws.uniform(-80, 80), draws.uniform(-3, 9)};
}

/// At least 1 m from each other and from `others`: none is nearer to another one's target than that one.
inline std::vector<rt::Vector3> scattered(int count, double wide_m, Draws& draws,
                                          const std::vector<rt::Vector3>& others = {}) {
  std::vector<rt::Vector3> points;
  while (static_cast<int>(points.size()) < count) {
    const rt::Vector3 p{draws.uniform(-wide_m, wide_m), draws.uniform(-wide_m, wide_m),
                        draws.uniform(-0.5, 3)};
    const auto is_near = [&](const rt::Vector3& o) {
      return std::hypot(p.x - o.x, p.y - o.y, p.z - o.z) < 1.0;
    };
    if (std::any_of(points.begin(), points.end(), is_near)) continue;
    if (std::any_of(others.begin(), others.end(), is_near)) continue;
    points.push_back(p);
  }
  return points;
}

/// How far the pose found puts a point of the local map from where it is, m.
inline double miss_m(const mapping::LevelPlace& found, const LevelPose& truth, const rt::Vector3& p) {
  const rt::Vector3 there = truth(p);
  return std::hypot(found.cosine * p.x - found.sine * p.y + found.x_m - there.x,
                    found.sine * p.x + found.cosine * p.y + found.y_m - there.y, p.z + found.z_m - there.z);
}

}  // namespace sortie::testing
