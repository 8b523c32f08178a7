// SPDX-License-Identifier: BSD-3-Clause
// Did a flight's vehicle meet a box? Asked of the truth alone.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "firmware_like/live/live_run.hpp"
#include "rt/convex/query.hpp"

namespace sortie::testing {

/// An upright box of the world; there from a time of the run on.
struct TrueBox {
  rt::Vector3 low_m;
  rt::Vector3 size_m;
  double from_s{};
};

/// `world.boxes=[...]` of a scene, as an override.
inline std::string world_boxes(const std::vector<TrueBox>& boxes) {
  std::string rows;
  for (const TrueBox& b : boxes) {
    rows += (rows.empty() ? "{x_m=" : ",{x_m=") + std::to_string(b.low_m.x) +
            ",y_m=" + std::to_string(b.low_m.y) + ",z_m=" + std::to_string(b.low_m.z) +
            ",length_m=" + std::to_string(b.size_m.x) + ",width_m=" + std::to_string(b.size_m.y) +
            ",height_m=" + std::to_string(b.size_m.z) + ",from_s=" + std::to_string(b.from_s) + "}";
  }
  return "world.boxes=[" + rows + "]";
}

/// True when the vehicle's ellipsoid, without any margin, met a box at a known place of the truth. Requires
/// that the truth is known all along, 50 times a second.
inline bool met_a_box(const firmware::LiveRunOutcome& run, const std::vector<TrueBox>& boxes) {
  REQUIRE(static_cast<double>(run.truth.size()) > 50 * run.results.duration_s);
  REQUIRE_FALSE(run.truth.empty());
  rt::convex::Convex robot = rt::convex::make_swept_ellipsoid({0.45, 0.45, 0.15}, {});
  for (const auto& truth : run.truth) {
    robot.p_world_m = {truth.p[0], truth.p[1], truth.p[2]};
    const double since_s = rt::to_seconds(truth.stamp_ns - run.truth.front().stamp_ns);
    for (const TrueBox& b : boxes) {
      if (since_s < b.from_s) continue;
      rt::convex::Convex body = rt::convex::make_box(0.5 * b.size_m);
      body.p_world_m = b.low_m + 0.5 * b.size_m;
      if (rt::convex::is_collision(rt::convex::query(robot, body).state)) return true;
    }
  }
  return false;
}

}  // namespace sortie::testing
