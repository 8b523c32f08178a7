// SPDX-License-Identifier: BSD-3-Clause
// Trajectory errors against cases worked out by hand, and recorded data.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <random>

#include "firmware_like/result/results.hpp"
#include "tests/toolchain/trajectory_poses.hpp"
#include "tests/toolchain/tum_reader.hpp"
#include "toolchain/import/text_file.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

Trajectory euroc_truth(const std::string& path) {
  TextFile file(path);
  Trajectory truth;
  std::vector<std::string_view> fields;
  std::string_view line;
  while (file.next(line)) {
    if (line.front() == '#') continue;
    split(line, ',', fields);
    TimedPose p;
    p.stamp_ns = std::stoll(std::string(fields[0]));
    for (std::size_t i = 0; i < 3; ++i) REQUIRE(parse_double(fields[1 + i], p.p[i]));
    for (std::size_t i = 0; i < 4; ++i) REQUIRE(parse_double(fields[4 + i], p.q[i]));
    truth.push_back(p);
  }
  return truth;
}

}  // namespace

TEST_CASE("statistics are those of the definition") {
  const std::vector<double> errors{1.0, 2.0, 2.0, 5.0};
  const ErrorStats s = statistics(errors);
  CHECK(s.n == 4);
  CHECK(s.rmse == Approx(std::sqrt(34.0 / 4.0)));
  CHECK(s.mean == Approx(2.5));
  CHECK(s.median == Approx(2.0));
  CHECK(s.max == 5.0);
  CHECK(statistics({}).n == 0);
  CHECK(statistics(std::vector<double>{3.0}).median == 3.0);
}

TEST_CASE("relative errors of a scale error are its share of the way") {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i <= 1000; ++i) {
    truth.push_back(pose(0.1 * i, 0.1 * i, 0));
    estimate.push_back(pose(0.1 * i, 0.102 * i, 0));
  }
  const PairedTrajectories pairs{estimate, truth, 0};
  const RelativeErrors by_metres = relative_pose_error(pairs, 10.25);
  CHECK(by_metres.translation_m.n == 8);  // every 101 frames, the first after 101
  CHECK(by_metres.translation_m.rmse == Approx(0.202));
  const Drift drift = end_drift(pairs);
  CHECK(drift.distance_m == Approx(100.0));
  CHECK(drift.horizontal_percent == Approx(2.0));
  CHECK(drift.vertical_percent == 0.0);
}

TEST_CASE("noise of a GPS does not lengthen the way, and a lost estimate does not shorten it") {
  std::mt19937 random(6);
  const auto noise = [&random] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  PairedTrajectories pairs;
  for (int i = 0; i <= 1000; ++i) {
    const double dx = noise();
    const double dy = noise();
    pairs.estimate.push_back(pose(0.1 * i, 0.1 * i, 0));
    pairs.truth.push_back(pose(0.1 * i, 0.1 * i + 0.2 * dx, 0.2 * dy));
    pairs.truth.back().flags = rt::kTruthPosition;
  }
  CHECK(end_drift(pairs).distance_m == Approx(100.0));
  for (TimedPose& p : pairs.truth) p.flags |= rt::kTruthOrientation;
  CHECK(end_drift(pairs).distance_m > 110.0);
  for (TimedPose& p : pairs.truth) p.flags = rt::kTruthPosition;
  for (TimedPose& p : pairs.estimate) p.p[0] = 0.0;
  CHECK(end_drift(pairs).distance_m > 110.0);
}

TEST_CASE("an orientation error splits into tilt and heading") {
  for (const double heading : {0.0, 1e-9, 0.3, -2.9}) {
    for (const double tilt : {0.0, 1e-9, 0.2, 1.5}) {
      const Eigen::Quaterniond truth(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
      const Eigen::Quaterniond error =
          Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
          Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d(0.6, -0.8, 0)));
      TimedPose t;
      TimedPose e;
      set_orientation(t, truth);
      set_orientation(e, error * truth);
      for (double& x : e.q) x = -x;  // the same rotation
      const OrientationError found = orientation_error(e.q, t.q);
      INFO("heading " << heading << " tilt " << tilt);
      CHECK(found.inclination_rad == Approx(tilt).margin(1e-14));
      CHECK(found.heading_rad == Approx(heading).margin(1e-14));
    }
  }
}

TEST_CASE("orientation counts only while moving, and its heading starts at the first truth") {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 100; ++i) {
    truth.push_back(pose(0.01 * i, 0, 0, 0, 0.0));
    truth.back().flags = rt::kTruthOrientation;
    if (i >= 50) truth.back().flags |= rt::kTruthMoving;
    estimate.push_back(pose(0.01 * i, 0, 0, 0, i < 50 ? 1.0 : 1.25));
  }
  const Evaluation e = evaluate(estimate, truth);
  CHECK(e.errors.at("orientation_n") == 50);
  CHECK(e.errors.at("heading_rmse_deg") == Approx(0.25 * 180.0 / kPi));
  CHECK(e.errors.at("inclination_rmse_deg") < 1e-9);
  CHECK(e.errors.at("ate_n") == 0);
  CHECK(e.errors.count("ate_rmse_m") == 0);
  for (TimedPose& p : truth) p.flags = rt::kTruthOrientation;
  CHECK(evaluate(estimate, truth).errors.at("orientation_n") == 100);
}

TEST_CASE("an estimate of attitude alone has no position error") {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 100; ++i) {
    truth.push_back(pose(0.01 * i, 5.0, 6.0, 7.0, 0.1));
    truth.back().flags |= rt::kTruthMoving;
    estimate.push_back(pose(0.01 * i, 0, 0, 0, 0.1));
    estimate.back().flags = rt::kTruthOrientation;
  }
  const Evaluation e = evaluate(estimate, truth);
  CHECK(e.errors.count("ate_rmse_m") == 0);
  CHECK(e.errors.count("drift_horizontal_percent") == 0);
  CHECK(e.errors.at("orientation_n") == 100);
  CHECK(std::isnan(e.series.front().position_m));
}

TEST_CASE("a recorded flight has the published error") {
  const std::string folder = std::string(SORTIE_DATA_DIR) + "/traj_refs";
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: no recorded data in " << folder);
    return;
  }
  const Trajectory estimate = read_tum(folder + "/V102.txt");
  const Trajectory truth = euroc_truth(folder + "/V102_groundtruth.csv");
  EvaluationOptions options;
  options.align = Alignment::se3;
  const Evaluation e = evaluate(estimate, truth, options);
  CHECK(e.errors.at("ate_n") == 797);
  CHECK(e.errors.at("ate_rmse_m") == Approx(0.0916).margin(5e-5));
  CHECK(e.errors.at("distance_m") == Approx(75.9).margin(0.5));
}

TEST_CASE("two paths of a run are judged by one truth, each by its own name") {
  struct Outcome {
    Trajectory estimate, located, truth;
    Results results;
  } run;
  for (int i = 0; i < 20; ++i) {
    run.truth.push_back(pose(i, i, 0));
    run.estimate.push_back(pose(i, i, 0.3));
    run.located.push_back(pose(i, i, 0.01));
  }
  const Evaluation both = judge(run);
  CHECK(run.results.errors.at("ate_rmse_m") == Approx(0.3));
  CHECK(run.results.errors.at("located_ate_rmse_m") == Approx(0.01));
  CHECK(both.located.estimate.size() == 20);
  run.estimate.clear();
  const Evaluation alone = judge(run);
  CHECK(run.results.errors.count("ate_rmse_m") == 0);
  CHECK(run.results.errors.at("located_ate_max_m") == Approx(0.01));
  CHECK(alone.series.size() == 20);
  // What moves one of them to the truth does not move the other.
  run.estimate = run.truth;
  for (TimedPose& p : run.located) p.p[0] += 5.0;
  EvaluationOptions first;
  first.align = Alignment::first;
  static_cast<void>(judge(run, first));
  CHECK(run.results.errors.at("ate_rmse_m") < 1e-9);
  CHECK(run.results.errors.at("located_ate_rmse_m") < 1e-9);
}
