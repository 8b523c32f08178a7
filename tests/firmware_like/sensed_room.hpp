// SPDX-License-Identifier: BSD-3-Clause
// A flight on the map of the vehicle's own lidar: to a place behind a wall that it was never told of, with
// the swept truth judged against the world's boxes; replay and keyframes.
#pragma once

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/met_a_box.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {

// The boxes of scene uav_room_sensed that a flight could meet.
inline std::vector<TrueBox> sensed_room_boxes() {
  return {{{-2, -4, 3}, {14, 8, 0.2}},   {{-2, -4, 0}, {14, 0.2, 3}},  {{-2, 3.8, 0}, {14, 0.2, 3}},
          {{-2, -4, 0}, {0.2, 8, 3}},    {{11.8, -4, 0}, {0.2, 8, 3}}, {{4, -3.8, 0}, {0.2, 5, 3}},
          {{6.5, 0.2, 0}, {0.4, 0.4, 3}}};
}

// A box that comes up under way: behind the opening of the wall, across the way that the vehicle has taken.
inline constexpr TrueBox kLateBox{{4.6, -0.6, 0}, {0.4, 2.6, 3}, 6.5};

// Flies the scene, holds the ellipsoid against the true boxes, and replays from the start and from keyframes.
inline std::map<std::string, std::uint64_t> fly_sensed_room(double seconds,
                                                            const std::vector<std::string>& from,
                                                            bool late_box = false) {
  using namespace firmware;
  using namespace toolchain;
  const TempFolder folder;
  const std::string log = folder.file("room.lcm");
  LiveRunOptions options;
  options.scene = "uav_room_sensed";
  std::vector<TrueBox> boxes = sensed_room_boxes();
  if (late_box) boxes.push_back(kLateBox);
  if (late_box) options.overrides = {world_boxes(boxes)};
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = log;
  options.record_fields = true;
  options.lcm_url = "none";
  const LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot, options);
  CHECK_FALSE(met_a_box(run, boxes));
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
