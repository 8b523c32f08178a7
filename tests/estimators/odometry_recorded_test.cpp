// SPDX-License-Identifier: BSD-3-Clause
// Dead reckoning of two real robots: a lawn mower (Plaza) and a skid-steer robot (Husky), against satellite
// positions.
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>

#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "tests/estimators/recorded.hpp"

namespace {
using namespace sortie;

struct Point {
  double t_s, x_m, y_m;
};

struct Fit {
  double rmse_m{};
  double max_m{};
  std::size_t points{};
};

/// Errors of the track, interpolated in time, at the truth's stamps; in 2-D, aligned by a rigid motion if
/// asked for.
Fit compare(const std::vector<Point>& track, const std::vector<Point>& truth, bool align) {
  std::vector<Point> a;
  std::vector<Point> b;
  std::size_t k = 0;
  for (const Point& p : truth) {
    while (k + 1 < track.size() && track[k + 1].t_s < p.t_s) ++k;
    if (k + 1 >= track.size() || track[k].t_s > p.t_s) continue;
    const double u = (p.t_s - track[k].t_s) / (track[k + 1].t_s - track[k].t_s);
    a.push_back({p.t_s, track[k].x_m + u * (track[k + 1].x_m - track[k].x_m),
                 track[k].y_m + u * (track[k + 1].y_m - track[k].y_m)});
    b.push_back(p);
  }
  const auto n = static_cast<double>(a.size());
  double ax = 0, ay = 0, bx = 0, by = 0, angle = 0;
  if (align) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      ax += a[i].x_m / n;
      ay += a[i].y_m / n;
      bx += b[i].x_m / n;
      by += b[i].y_m / n;
    }
    double s = 0, c = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      c += (a[i].x_m - ax) * (b[i].x_m - bx) + (a[i].y_m - ay) * (b[i].y_m - by);
      s += (a[i].x_m - ax) * (b[i].y_m - by) - (a[i].y_m - ay) * (b[i].x_m - bx);
    }
    angle = std::atan2(s, c);
  }
  Fit fit{0, 0, a.size()};
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double dx = a[i].x_m - ax;
    const double dy = a[i].y_m - ay;
    const double error = std::hypot(std::cos(angle) * dx - std::sin(angle) * dy - (b[i].x_m - bx),
                                    std::sin(angle) * dx + std::cos(angle) * dy - (b[i].y_m - by));
    fit.rmse_m += error * error / n;
    fit.max_m = std::max(fit.max_m, error);
  }
  fit.rmse_m = std::sqrt(fit.rmse_m);
  return fit;
}

bool skipped(const char* file) {
  if (tests::has_data(file)) return false;
  WARN("skipped: no recorded data under " SORTIE_DATA_DIR);
  return true;
}
}  // namespace

TEST_CASE("The lawn mower's 1.86 km come out within 2 m rmse without any alignment") {
  if (skipped("plaza_odom/Plaza1_DR.txt")) return;
  const auto rows = tests::read_numbers("plaza_odom/Plaza1_DR.txt");
  const auto truth_rows = tests::read_numbers("plaza_odom/Plaza1_GT.csv");
  const double epoch_s = truth_rows[0][0];
  estimators::AttitudeConfig attitude_config;
  rt::store(rt::from_yaw_pitch_roll(truth_rows[0][3], 0, 0), attitude_config.q_world_body);
  estimators::Attitude attitude{attitude_config};
  estimators::TrackOdometry odometry{estimators::TrackOdometryConfig{}};

  std::vector<Point> track;
  double travel_m = 0;
  double turn_rad = 0;
  rt::Nanoseconds last_ns = 0;
  const auto feed = [&](rt::Nanoseconds stamp_ns, double rate_rad_s) {
    rt::ImuSample imu{stamp_ns, {0, 0, rate_rad_s}, {}, rt::kImuGyr | rt::kImuMeanRate};
    REQUIRE(attitude.update(imu) == Status::ok);
    REQUIRE(odometry.observe(attitude.estimate()) == Status::ok);
    REQUIRE(odometry.update({stamp_ns, travel_m, travel_m, 0}) == Status::ok);
    const auto& p = odometry.estimate().p_world_body_m;
    track.push_back({rt::to_seconds(stamp_ns), p[0], p[1]});
    last_ns = stamp_ns;
  };
  feed(0, 0);
  for (const auto& row : rows) {
    const rt::Nanoseconds stamp_ns = tests::to_ns(row[0], epoch_s);
    travel_m += row[1];
    turn_rad += row[2];
    feed(stamp_ns, row[2] / rt::to_seconds(stamp_ns - last_ns));
  }
  CHECK(std::fabs(attitude.estimate().delta_heading_rad - turn_rad) < 1e-9);  // the sum of what went in
  CHECK(std::fabs(odometry.estimate().distance_m - travel_m) < 1e-9);
  std::vector<Point> truth;
  for (const auto& row : truth_rows)
    truth.push_back({rt::to_seconds(tests::to_ns(row[0], epoch_s)), row[1], row[2]});
  const Fit fit = compare(track, truth, false);
  std::clog << "Plaza1: rmse " << fit.rmse_m << " m, max " << fit.max_m << " m, n " << fit.points << "\n";
  CHECK(fit.points > 9600);
  CHECK(fit.rmse_m < 2.0);
  CHECK(fit.max_m < 4.6);
  // The covariance must not be far too proud: the true error within four of its sigmas at the end.
  const auto& pose = odometry.estimate();
  const Point& end = truth.back();
  const double sigma = std::sqrt(pose.covariance[0] + pose.covariance[7]);
  CHECK(std::hypot(pose.p_world_body_m[0] - end.x_m, pose.p_world_body_m[1] - end.y_m) < 4 * sigma);
  CHECK(sigma < 30.0);
}

TEST_CASE("The skid-steer robot's 195 m come out within 3.3 m rmse, in the order of receipt") {
  if (skipped("husky_skid/husky_a_imu.csv")) return;
  const auto imu = tests::read_numbers("husky_skid/husky_a_imu.csv");
  const auto wheels = tests::read_numbers("husky_skid/husky_a_odom.csv");
  const auto gps = tests::read_numbers("husky_skid/husky_a_gps.csv");
  REQUIRE(imu.size() > 6000);
  const double epoch_s = std::floor(imu[0][0]);
  estimators::Attitude attitude{estimators::AttitudeConfig{}};
  estimators::TrackOdometryConfig config;
  config.track_width_m = 1.07;
  estimators::TrackOdometry odometry{config};

  std::vector<Point> track;
  double left_m = 0;
  double right_m = 0;
  std::size_t i = 0;
  for (std::size_t k = 0; k < wheels.size(); ++k) {
    for (; i < imu.size() && imu[i][0] <= wheels[k][0]; ++i) {
      const auto& r = imu[i];
      const rt::ImuSample sample{tests::to_ns(r[1], epoch_s),
                                 {-r[4], -r[2], r[3]},  // base = Rz(-90 deg) Rx(+90 deg) sensor
                                 {-r[7], -r[5], r[6]},
                                 rt::kImuGyr | rt::kImuAcc};
      REQUIRE(attitude.update(sample) == Status::ok);
      REQUIRE(odometry.observe(attitude.estimate()) == Status::ok);
    }
    const auto& now = wheels[k];
    if (k > 0) {
      const auto& before = wheels[k - 1];
      const double heading = 2 * std::atan2(before[7], before[8]);
      const double dx = now[2] - before[2];
      const double dy = now[3] - before[3];
      const double forward = dx * std::cos(heading) + dy * std::sin(heading);
      const double travel = std::copysign(std::hypot(dx, dy), forward);
      const double turn = rt::wrap_angle(2 * std::atan2(now[7], now[8]) - heading);
      left_m += travel - 0.5 * 1.07 * turn;
      right_m += travel + 0.5 * 1.07 * turn;
    }
    const rt::Nanoseconds stamp_ns = tests::to_ns(now[1], epoch_s);
    REQUIRE(odometry.update({stamp_ns, left_m, right_m, 0}) == Status::ok);
    const auto& p = odometry.estimate().p_world_body_m;
    track.push_back({rt::to_seconds(stamp_ns), p[0], p[1]});
  }
  std::vector<Point> truth;
  for (const auto& row : gps) {
    const double east = (row[4] - gps[0][4]) * 111320 * std::cos(gps[0][3] / 57.29577951308232);
    truth.push_back({rt::to_seconds(tests::to_ns(row[1], epoch_s)), east, (row[3] - gps[0][3]) * 111080});
  }
  const Fit fit = compare(track, truth, true);
  std::clog << "Husky: rmse " << fit.rmse_m << " m, max " << fit.max_m << " m, n " << fit.points << ", way "
            << odometry.estimate().distance_m << " m, slips " << odometry.counters().slips << ", stale "
            << odometry.counters().attitude_stale << ", z " << odometry.estimate().p_world_body_m[2]
            << ", bias z " << attitude.estimate().bias_rad_s[2] << "\n";
  CHECK(fit.points > 490);
  CHECK(fit.rmse_m < 3.3);
  CHECK(fit.max_m < 6.0);
  CHECK(odometry.counters().attitude_stale == 0);
}
