// SPDX-License-Identifier: BSD-3-Clause
// A corridor without ends: what the locator says of its place along it, and what ICP with a fixed sigma says.
#include <cmath>
#include <deque>

#include "mapping/registration/pose_algebra.hpp"
#include "tests/bench/registration/hall_case.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/registration/scan_peers.hpp"
#include "tests/bench/report/front.hpp"
#include "tests/bench/report/picture.hpp"

namespace sortie::bench {
namespace {

constexpr double kStep_m = 0.2;
constexpr int kScans = 200;
constexpr int kSubmap = 5;               ///< scans that the naive method matches to, as its source does
constexpr double kFixedSigma_m = 0.005;  ///< of each match, whatever the geometry: the same source
constexpr double kOdometryScale = 1.02;  ///< tracks that slip
constexpr double kOdometrySigma_m = 0.02;
constexpr double kOdometrySigmaPerWay = 0.2;

testing::RegistrationWorld corridor_world() {
  testing::RegistrationWorld world;
  world.boxes = {{{0, -2.1, 0}, {500, 1, 10}, 0},  // walls 1.1 and 1.3 m aside
                 {{0, 2.3, 0}, {500, 1, 10}, 0},
                 {{0, 0, -1.6}, {500, 10, 1}, 0},  // floor 0.6 m below
                 {{0, 0, 3.0}, {500, 10, 1}, 0}};  // ceiling 2 m above
  return world;
}

/// One method's place along the corridor, scan by scan.
struct CorridorRun {
  std::vector<double> error_m;
  std::vector<double> sigma_m;  ///< that it claims, its steps taken together
};

struct CorridorDrive {
  std::vector<PlacedScan> scans;
  std::vector<mapping::RigidPose> odometry;
};

CorridorDrive corridor_drive(testing::Draws& draws) {
  const testing::RegistrationWorld world = corridor_world();
  const testing::TestLidar lidar;
  CorridorDrive drive;
  double odometry_m = 0.0;
  for (int i = 0; i < kScans; ++i) {
    PlacedScan scan;
    scan.pose.p = {kStep_m * i, 0, 0};
    scan.points = lidar.scan(world, scan.pose.p, scan.pose.q, draws);
    drive.scans.push_back(std::move(scan));
    drive.odometry.push_back({{odometry_m, 0, 0}, {}});
    odometry_m += kOdometryScale * kStep_m + 0.003 * draws.normal();
  }
  return drive;
}

CorridorRun located_run(const CorridorDrive& drive, int& weak_named) {
  std::vector<std::byte> memory(std::size_t{32} << 20);
  rt::Arena arena(memory);
  mapping::Locator locator(mapping::RegistrationConfig{}, arena);
  CorridorRun run;
  double variance = 0.0;
  for (int i = 0; i < kScans; ++i) {
    rt::PointScan scan;
    scan.header.stamp_ns = rt::Nanoseconds{100'000'000} * (i + 1);
    scan.header.points = static_cast<std::uint32_t>(drive.scans[i].points.size());
    scan.points = drive.scans[i].points.data();
    mapping::OdometryHint hint;
    hint.known = true;
    hint.T_odom_sensor = drive.odometry[i];
    hint.sigma_move_m = kOdometrySigma_m + kOdometrySigmaPerWay * kStep_m;
    const mapping::Located& located = locator.locate(scan, hint);
    if (i > 0) {
      const bool named = located.weak_moves == 1 && std::fabs(located.weak_move[0].axis_map[0]) > 0.99;
      weak_named += named ? 1 : 0;
      variance += located.covariance[0];
    }
    run.error_m.push_back(located.T_map_sensor.p.x - drive.scans[i].pose.p.x);
    run.sigma_m.push_back(std::sqrt(variance));
  }
  return run;
}

std::vector<mapping::SamplePoint> sample_of(const PlacedScan& scan) {
  std::vector<mapping::SamplePoint> out;
  for (const rt::ScanPoint& p : scan.points) out.push_back({p.x_m, p.y_m, p.z_m});
  return out;
}

/// ICP, point to plane, to the five scans before; fused with the odometry, each with its sigma.
CorridorRun naive_run(const CorridorDrive& drive) {
  CorridorRun run;
  std::deque<std::pair<mapping::RigidPose, int>> submap;
  mapping::RigidPose pose;
  double variance = 0.0;
  for (int i = 0; i < kScans; ++i) {
    if (i > 0) {
      std::vector<rt::Vector3> map;
      for (const auto& [at, number] : submap) {
        for (const rt::ScanPoint& p : drive.scans[number].points)
          map.push_back(at.p + rt::rotate(at.q, {static_cast<double>(p.x_m), static_cast<double>(p.y_m),
                                                 static_cast<double>(p.z_m)}));
      }
      const double moved = drive.odometry[i].p.x - drive.odometry[i - 1].p.x;
      const mapping::RigidPose start{pose.p + rt::rotate(pose.q, {moved, 0, 0}), pose.q};
      ScanPeers peers(map);
      const PeerResult matched = peers.align(kIcp, sample_of(drive.scans[i]), start);
      const double odometry_m = kOdometrySigma_m + kOdometrySigmaPerWay * kStep_m;
      const double of_match = 1 / (kFixedSigma_m * kFixedSigma_m);
      const double of_odometry = 1 / (odometry_m * odometry_m);
      pose.q = matched.pose.q;
      pose.p = 1 / (of_match + of_odometry) * (of_match * matched.pose.p + of_odometry * start.p);
      variance += 1 / (of_match + of_odometry);
    }
    submap.emplace_back(pose, i);
    if (submap.size() > kSubmap) submap.pop_front();
    run.error_m.push_back(pose.p.x - drive.scans[i].pose.p.x);
    run.sigma_m.push_back(std::sqrt(variance));
  }
  return run;
}

void add_curves(Picture& picture, const std::string& name, const CorridorRun& run, int colour) {
  Curve error, low, high;
  error.name = name + ": error";
  low.name = name + ": what it claims, two sigma";
  low.style = high.style = "dashed";
  error.colour = low.colour = high.colour = colour;
  for (std::size_t i = 0; i < run.error_m.size(); ++i) {
    for (Curve* curve : {&error, &low, &high}) curve->x.push_back(kStep_m * static_cast<double>(i));
    error.y.push_back(run.error_m[i]);
    low.y.push_back(run.error_m[i] - 2 * run.sigma_m[i]);
    high.y.push_back(run.error_m[i] + 2 * run.sigma_m[i]);
  }
  for (Curve* curve : {&error, &low, &high}) picture.curves.push_back(*curve);
}

Json row(const char* name, const CorridorRun& run) {
  const double error = run.error_m.back();
  const double sigma = run.sigma_m.back();
  return {name, decimals(error, 2), decimals(sigma, 3), decimals(std::fabs(error) / sigma, 1)};
}

}  // namespace

void measure_registration_corridor(const RegistrationSettings& settings, Report& report) {
  testing::Draws draws(settings.seed);
  const CorridorDrive drive = corridor_drive(draws);
  int named = 0;
  const CorridorRun ours = located_run(drive, named);
  Json rows = Json::array();
  rows.push_back(row("ours", ours));
  Picture picture{"bench-registration-corridor",
                  "corridor",
                  "A corridor without ends: place along it",
                  "way, m",
                  "error along the corridor, m",
                  false,
                  false,
                  false,
                  {}};
  add_curves(picture, "locate", ours, 0);
  if (has_pcl()) {
    const CorridorRun naive = naive_run(drive);
    rows.push_back(row("ICP, 5 mm", naive));
    add_curves(picture, "ICP with a fixed sigma of 5 mm", naive, 1);
  }
  const double odometry_m = drive.odometry.back().p.x - drive.scans.back().pose.p.x;
  rows.push_back({"odometry", decimals(odometry_m, 2), "", ""});
  report.add_table("corridor",
                   {"after " + decimals(kStep_m * (kScans - 1), 0) + " m", "error along m", "claimed sigma m",
                    "error over sigma"},
                   rows);
  add_picture(report, picture);
  Figure figure;
  figure.group = "corridor";
  figure.what = "scans that name the corridor's axis, and nothing else, as what they do not hold";
  figure.unit = "%";
  figure.n = kScans - 1;
  figure.ours = spread(100.0 * named / (kScans - 1));
  set_goal(figure, "99 at least", named >= 0.99 * (kScans - 1));
  report.add(figure);
  report.note(
      "corridor",
      "A scan each 0.2 m, odometry that is 2 % too long. ICP (point to plane, PCL) matches to the five "
      "scans before, and each match counts with 5 mm, whatever the geometry: to it the rings on the "
      "floor and on the walls fit best where the robot stands still.");
}

}  // namespace sortie::bench
