// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/timed_pose.hpp"

#include <catch2/catch.hpp>

using namespace sortie::firmware;

TEST_CASE("a trajectory never outgrows its bound, keeps its first pose and an even spacing") {
  BoundedTrajectory bounded(10, 64);
  for (std::int64_t stamp = 0; stamp < 100'000; ++stamp) {
    TimedPose pose;
    pose.stamp_ns = stamp;
    bounded.add(pose);
    REQUIRE(bounded.size() <= 64);
  }
  const Trajectory kept = bounded.take();
  REQUIRE(kept.size() >= 32);
  CHECK(kept.front().stamp_ns == 0);
  CHECK(kept.back().stamp_ns > 95'000);
  const std::int64_t spacing = kept[1].stamp_ns - kept[0].stamp_ns;
  CHECK(spacing == 2560);  // 10 doubled until 64 of them span the run
  for (std::size_t i = 1; i < kept.size(); ++i) CHECK(kept[i].stamp_ns - kept[i - 1].stamp_ns == spacing);
}
