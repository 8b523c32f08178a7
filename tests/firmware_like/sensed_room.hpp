// SPDX-License-Identifier: BSD-3-Clause
// A flight on the map of the vehicle's own lidar: to a place behind a wall that it was never told of, with
// the swept truth judged against the world's boxes; replay and keyframes.
#pragma once

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "rt/convex/query.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {

// The boxes of scene uav_room_sensed that a flight could meet: middle and half edges.
struct SensedRoomBox {
  rt::Vector3 middle_m;
  rt::Vector3 half_m;
};
inline constexpr SensedRoomBox kSensedRoom[] = {
    {{5, 0, 3.1}, {7, 4, 0.1}},        {{5, -3.9, 1.5}, {7, 0.1, 1.5}}, {{5, 3.9, 1.5}, {7, 0.1, 1.5}},
    {{-1.9, 0, 1.5}, {0.1, 4, 1.5}},   {{11.9, 0, 1.5}, {0.1, 4, 1.5}}, {{4.1, -1.3, 1.5}, {0.1, 2.5, 1.5}},
    {{6.7, 0.4, 1.5}, {0.2, 0.2, 1.5}}};

// A box that comes up under way: behind the opening of the wall, across the way that the vehicle has taken.
inline constexpr SensedRoomBox kLateBox{{4.8, 0.7, 1.5}, {0.2, 1.3, 1.5}};
inline constexpr double kLateBoxFromS = 6.5;

// `[[world.boxes]]` of the scene and the late one, as an override.
inline std::string boxes_with_late_one() {
  std::string rows;
  const auto row = [&rows](const SensedRoomBox& box, double from_s) {
    const rt::Vector3 low = box.middle_m - box.half_m;
    rows += (rows.empty() ? "{x_m=" : ",{x_m=") + std::to_string(low.x) + ",y_m=" + std::to_string(low.y) +
            ",z_m=" + std::to_string(low.z) + ",length_m=" + std::to_string(2 * box.half_m.x) +
            ",width_m=" + std::to_string(2 * box.half_m.y) + ",height_m=" + std::to_string(2 * box.half_m.z) +
            ",from_s=" + std::to_string(from_s) + "}";
  };
  for (const SensedRoomBox& box : kSensedRoom) row(box, 0);
  row(kLateBox, kLateBoxFromS);
  return "world.boxes=[" + rows + "]";
}

// Flies the scene, holds the ellipsoid against the true boxes, and replays from the start and from keyframes.
inline std::map<std::string, std::uint64_t> fly_sensed_room(double seconds,
                                                            const std::vector<std::string>& from,
                                                            bool late_box = false) {
  using namespace firmware;
  const TempFolder folder;
  const std::string log = folder.file("room.lcm");
  LiveRunOptions options;
  options.scene = "uav_room_sensed";
  if (late_box) options.overrides = {boxes_with_late_one()};
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = log;
  options.record_fields = true;
  options.lcm_url = "none";
  const LiveRunOutcome run = run_live(own_vehicles(), make_own_bench, options);
  // The vehicle's own size, without any margin, at each known place of the truth.
  REQUIRE(static_cast<double>(run.truth.size()) > 50 * seconds);
  rt::convex::Convex robot = rt::convex::make_swept_ellipsoid({0.45, 0.45, 0.15}, {});
  for (const auto& truth : run.truth) {
    robot.p_world_m = {truth.p[0], truth.p[1], truth.p[2]};
    for (const SensedRoomBox& box : kSensedRoom) {
      rt::convex::Convex body = rt::convex::make_box(box.half_m);
      body.p_world_m = box.middle_m;
      REQUIRE_FALSE(rt::convex::is_collision(rt::convex::query(robot, body).state));
    }
    const double since_s = rt::to_seconds(truth.stamp_ns - run.truth.front().stamp_ns);
    if (!late_box || since_s < kLateBoxFromS) continue;
    rt::convex::Convex body = rt::convex::make_box(kLateBox.half_m);
    body.p_world_m = kLateBox.middle_m;
    REQUIRE_FALSE(rt::convex::is_collision(rt::convex::query(robot, body).state));
  }
  const Indexed indexed = replay_and_keep(log, own_vehicles(), {}, 250, keyframe_path(log));
  CHECK(indexed.outcome.results.digest == run.results.digest);
  for (const std::string& start : from) {
    INFO(start);
    ReplayOptions part;
    part.from = start;
    const ReplayOutcome outcome = replay_log(log, part);
    if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
    CHECK(outcome.results.digest == run.results.digest);
  }
  return {run.results.counters.begin(), run.results.counters.end()};
}

}  // namespace sortie::testing
