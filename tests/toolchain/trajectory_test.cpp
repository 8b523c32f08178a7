// SPDX-License-Identifier: BSD-3-Clause
// Trajectories before they are compared: cleaned and interpolated.
#include <catch2/catch.hpp>

#include "tests/toolchain/trajectory_poses.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

TEST_CASE("a pose between two others is interpolated, and gaps are not bridged") {
  Trajectory t{pose(0, 0, 0), pose(1, 10, -4, 2, kPi / 2)};
  TimedPose p;
  REQUIRE(interpolate(t, kSecond / 4, 2 * kSecond, p));
  CHECK(p.p[0] == Approx(2.5));
  CHECK(p.p[1] == Approx(-1.0));
  CHECK(p.p[2] == Approx(0.5));
  CHECK(2.0 * std::atan2(p.q[3], p.q[0]) == Approx(kPi / 8));
  CHECK(interpolate(t, 0, 1, p));
  CHECK(interpolate(t, kSecond, 1, p));
  CHECK_FALSE(interpolate(t, -1, 2 * kSecond, p));
  CHECK_FALSE(interpolate(t, kSecond + 1, 2 * kSecond, p));
  CHECK_FALSE(interpolate(t, kSecond / 2, kSecond - 1, p));
  // Between a moving sample and one at rest nothing is sure to move.
  t[0].flags |= rt::kTruthMoving;
  t[1].flags &= ~rt::kTruthHeight;
  REQUIRE(interpolate(t, kSecond / 4, 2 * kSecond, p));
  CHECK(p.flags == (rt::kTruthPosition | rt::kTruthOrientation));
}

TEST_CASE("interpolation takes the shorter arc though the quaternion's sign flips") {
  Trajectory t{pose(0, 0, 0, 0, 0.1), pose(1, 0, 0, 0, 0.3)};
  for (double& x : t[1].q) x = -x;
  TimedPose p;
  REQUIRE(interpolate(t, kSecond / 2, kSecond, p));
  CHECK(std::fabs(2.0 * std::atan2(p.q[3], p.q[0])) == Approx(0.2));
}

TEST_CASE("the denser trajectory is interpolated at the stamps of the sparser") {
  Trajectory dense;
  for (int i = 0; i <= 100; ++i) dense.push_back(pose(0.01 * i, 0.01 * i, 0));
  const Trajectory sparse{pose(0.105, 0.105, 0), pose(0.505, 0.505, 0), pose(2.0, 2, 0)};
  for (const bool estimate_is_dense : {true, false}) {
    const PairedTrajectories pairs = estimate_is_dense ? associate(dense, sparse) : associate(sparse, dense);
    REQUIRE(pairs.truth.size() == 2);
    CHECK(pairs.skipped == 1);
    CHECK(pairs.truth[0].stamp_ns == 105'000'000);
    CHECK(pairs.estimate[0].stamp_ns == 105'000'000);
    CHECK(absolute_trajectory_error(pairs).max < 1e-12);
  }
}

TEST_CASE("unusable samples are removed and the rest is sorted") {
  Trajectory t{pose(2, 1, 1), pose(0, 0, 0), pose(1, std::nan(""), 0), pose(3, 1, 1)};
  for (double& x : t[3].q) x = 0.0;
  t[0].q[0] = 1.001;
  CHECK(tidy(t) == 2);
  REQUIRE(t.size() == 2);
  CHECK(t[0].stamp_ns == 0);
  CHECK(t[1].q[0] == Approx(1.0));
}

TEST_CASE("trajectories without common time give no error but a zero count") {
  const Evaluation e = evaluate({pose(0, 0, 0), pose(1, 0, 0)}, {pose(5, 0, 0), pose(6, 0, 0)});
  CHECK(e.errors.at("ate_n") == 0);
  CHECK(e.errors.size() == 1);
  CHECK(evaluate({}, {}).errors.at("ate_n") == 0);
}
