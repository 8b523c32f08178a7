// SPDX-License-Identifier: BSD-3-Clause
// Alignment of trajectories: laws that must hold for random motions, and what no alignment may do.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/toolchain/trajectory_poses.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

RigidTransform random_motion(std::mt19937& random, bool planar) {
  const auto unit = [&random] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  const double a = unit();
  const double b = unit();
  const double c = unit();
  const double angle = 6.0 * unit();
  const Eigen::Vector3d axis =
      planar ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d(a, b, c + 1e-9).normalized();
  RigidTransform t;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(t.r) =
      Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  t.t[0] = 20.0 * a;
  t.t[1] = 20.0 * b;
  t.t[2] = 20.0 * c;
  return t;
}

}  // namespace

TEST_CASE("a constant offset is an error without alignment and none with it") {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 50; ++i) {
    const double s = 0.1 * i;
    truth.push_back(pose(s, s, 0.3 * s * s));
    estimate.push_back(pose(s, s + 3.0, 0.3 * s * s + 4.0));
  }
  EvaluationOptions options;
  CHECK(evaluate(estimate, truth, options).errors["ate_rmse_m"] == Approx(5.0));
  for (const Alignment a : {Alignment::first, Alignment::se2, Alignment::se3}) {
    options.align = a;
    INFO(to_string(a));
    CHECK(evaluate(estimate, truth, options).errors["ate_rmse_m"] < 1e-9);
  }
}

TEST_CASE("alignment finds any rigid motion back, and se2 only those about the vertical") {
  std::mt19937 random(20240611);
  for (int round = 0; round < 200; ++round) {
    INFO("round " << round << " of seed 20240611");
    const Trajectory truth = random_walk(random, 60, 0.1);
    for (const bool planar : {true, false}) {
      Trajectory estimate = truth;
      move_by(random_motion(random, planar), estimate);
      PairedTrajectories pairs{estimate, truth, 0};
      for (const Alignment a : {Alignment::first, Alignment::se2, Alignment::se3}) {
        PairedTrajectories aligned = pairs;
        move_by(find_alignment(pairs, a), aligned.estimate);
        const double error = absolute_trajectory_error(aligned).max;
        if (a == Alignment::se2 && !planar) continue;
        CHECK(error < 1e-9);
      }
      // Relative errors do not know frames.
      const RelativeErrors rpe = relative_pose_error(pairs, 1.0);
      CHECK(rpe.translation_m.n > 3);
      CHECK(rpe.translation_m.max < 1e-9);
      CHECK(rpe.rotation_rad.max < 1e-7);
    }
  }
}

TEST_CASE("no small motion of the estimate lowers the error that se3 alignment reached") {
  std::mt19937 random(5);
  Trajectory truth = random_walk(random, 80, 0.1);
  Trajectory estimate = random_walk(random, 80, 0.1);
  PairedTrajectories pairs{estimate, truth, 0};
  move_by(find_alignment(pairs, Alignment::se3), pairs.estimate);
  const double best = absolute_trajectory_error(pairs).rmse;
  for (int i = 0; i < 300; ++i) {
    RigidTransform nudge = random_motion(random, false);
    // A thousandth of a random motion about the middle of the path.
    const Eigen::Matrix3d r = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(nudge.r);
    const Eigen::AngleAxisd small(1e-3 * Eigen::AngleAxisd(r).angle(), Eigen::AngleAxisd(r).axis());
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(nudge.r) = small.toRotationMatrix();
    for (double& x : nudge.t) x *= 1e-3;
    PairedTrajectories moved = pairs;
    move_by(nudge, moved.estimate);
    CHECK(absolute_trajectory_error(moved).rmse >= best - 1e-12);
  }
}

TEST_CASE("alignment never mirrors, even if that fits better") {
  std::mt19937 random(9);
  const Trajectory truth = random_walk(random, 50, 0.1);
  Trajectory estimate = truth;
  for (TimedPose& p : estimate) p.p[2] = -p.p[2];
  const RigidTransform t = find_alignment({estimate, truth, 0}, Alignment::se3);
  CHECK((Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(t.r).determinant()) == Approx(1.0));
}

TEST_CASE("a truth without height judges the plane only, and se3 then stays upright") {
  std::mt19937 random(3);
  Trajectory truth = random_walk(random, 50, 0.1);
  Trajectory estimate = truth;
  move_by(random_motion(random, true), estimate);
  for (TimedPose& p : truth) {
    p.p[2] = 1000.0;  // an altitude from a GPS
    p.flags = rt::kTruthPosition;
  }
  for (const Alignment a : {Alignment::se2, Alignment::se3}) {
    EvaluationOptions options;
    options.align = a;
    const Evaluation e = evaluate(estimate, truth, options);
    CHECK(e.errors.at("ate_rmse_m") < 1e-9);
    CHECK(e.errors.count("drift_vertical_percent") == 0);
    CHECK(e.errors.count("heading_rmse_deg") == 0);
    CHECK(e.pairs.estimate[7].p[2] == Approx(estimate[7].p[2]));
  }
}

TEST_CASE("alignments have names and unknown names are refused with the list") {
  for (const char* name : {"none", "first", "se2", "se3"})
    CHECK(std::string(to_string(parse_alignment(name))) == name);
  CHECK_THROWS_WITH(parse_alignment("sim3"), Catch::Contains("sim3") && Catch::Contains("se2"));
}
