// SPDX-License-Identifier: BSD-3-Clause
// An elevation map that looks at places whose heights are known.
#pragma once

#include <catch2/catch.hpp>
#include <vector>

#include "tests/mapping/elevation_twin.hpp"

namespace sortie::tests {

// A map that looks at places in the world, one scan each call, from a sensor that never turns.
struct Looker {
  explicit Looker(const mapping::ElevationConfig& config = {}) : owned(config) {
    REQUIRE(owned.map.usable());
    REQUIRE(owned.map.centre_on({0, 0, 0}) == Status::ok);
  }
  void look(const rt::Vector3& from, const std::vector<rt::Vector3>& at) {
    std::vector<rt::ScanPoint> points;
    for (const rt::Vector3& p : at) {
      const rt::Vector3 way = p - from;
      points.push_back(
          {static_cast<float>(way.x), static_cast<float>(way.y), static_cast<float>(way.z), 0, 0});
    }
    REQUIRE(owned.map.update(scan_of(points, ++stamp), {from, {}}) == Status::ok);
  }
  mapping::GroundSpan ground(double x, double y, double asker = 0) const {
    return owned.map.view().ground_at(x, y, asker);
  }
  OwnedElevation owned;
  rt::Nanoseconds stamp{};
};

// Points of a level patch, 2 cm apart.
inline std::vector<rt::Vector3> patch(double x0, double x1, double y0, double y1, double z) {
  std::vector<rt::Vector3> points;
  for (double x = x0 + 0.01; x < x1; x += 0.02)
    for (double y = y0 + 0.01; y < y1; y += 0.02) points.push_back({x, y, z});
  return points;
}

inline mapping::ElevationConfig window_64() {
  mapping::ElevationConfig config;
  config.size = 64;
  return config;
}

}  // namespace sortie::tests
