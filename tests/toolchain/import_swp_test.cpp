// SPDX-License-Identifier: BSD-3-Clause
// Sweeps with a time for each point: into the log and, with the odometry beside them, straight again.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "mapping/grid/sweep.hpp"
#include "tests/toolchain/import_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

constexpr double kHalfTurn_rad = 3.14159265358979323846;
constexpr std::uint32_t kSweptRows = 4;
constexpr std::uint32_t kSweptColumns = 64;
constexpr std::uint32_t kSweptStep_ns = 1'500'000;  // a turn takes 96 ms

struct SweptPoint {
  float x_m, y_m, z_m;
  std::uint32_t t_ns;
};

std::string swp_bytes(const std::vector<SweptPoint>& points, std::uint32_t rows, std::uint32_t columns) {
  std::string bytes = "SWP1";
  bytes.append(reinterpret_cast<const char*>(&rows), 4);
  bytes.append(reinterpret_cast<const char*>(&columns), 4);
  bytes.append(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(SweptPoint));
  return bytes;
}

/// A sweep whose points tell their row and column.
std::vector<SweptPoint> numbered_sweep() {
  std::vector<SweptPoint> points;
  for (std::uint32_t i = 0; i < kSweptRows; ++i)
    for (std::uint32_t j = 0; j < kSweptColumns; ++j)
      points.push_back({static_cast<float>(j), static_cast<float>(i), 0.5f, j * kSweptStep_ns});
  return points;
}

SweptPoint& point_at(std::vector<SweptPoint>& points, std::uint32_t row, std::uint32_t column) {
  return points[row * kSweptColumns + column];
}

/// Where a robot is that drives a bend: its pose in closed form.
mapping::StampedPose driven_bend(double t_s) {
  const double yaw = 0.9 * t_s;
  mapping::StampedPose pose;
  pose.p = {0.8 / 0.9 * std::sin(yaw), 0.8 / 0.9 * (1.0 - std::cos(yaw)), 0.0};
  pose.q = rt::from_yaw_pitch_roll(yaw, 0.0, 0.0);
  return pose;
}

}  // namespace

TEST_CASE("a sweep comes in oldest point first, each with its time before the newest") {
  const TempFolder folder;
  std::vector<SweptPoint> points = numbered_sweep();
  point_at(points, 1, 3).x_m = std::nanf("");
  point_at(points, 2, 3).t_ns = 0;  // some drivers give no time to what is no return
  point_at(points, 2, 3).y_m = std::nanf("");
  point_at(points, 3, 9).z_m = std::numeric_limits<float>::infinity();
  const Outcome outcome =
      run("swp", folder.write("a.swp", swp_bytes(points, kSweptRows, kSweptColumns)), folder.file("out.lcm"));
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.returns.in == kSweptRows * kSweptColumns);
  CHECK(outcome.report.returns.used == kSweptRows * kSweptColumns - 3);
  CHECK(outcome.report.returns.no_return == 2);
  CHECK(outcome.report.returns.not_finite == 1);
  REQUIRE(outcome.report.warnings.size() == 1);
  CHECK(outcome.report.warnings[0].find("odom.csv: not there") != std::string::npos);
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.scans.size() == 1);
  CHECK(log.scans[0].flags == 0);
  CHECK(log.scans[0].stamp_ns == std::int64_t{kSweptStep_ns} * (kSweptColumns - 1));
  REQUIRE(log.points[0].size() == kSweptRows * kSweptColumns - 3);
  for (std::size_t k = 0; k < log.points[0].size(); ++k) {
    const rt::ScanPoint& point = log.points[0][k];
    CHECK(point.age_10us == 150 * (kSweptColumns - 1 - static_cast<std::uint32_t>(point.x_m)));
    if (k == 0) continue;
    const rt::ScanPoint& before = log.points[0][k - 1];
    CHECK((before.x_m < point.x_m || (before.x_m == point.x_m && before.y_m < point.y_m)));
  }
}

TEST_CASE("points that are no return do not count for the turn, whatever their times") {
  const TempFolder folder;
  std::vector<SweptPoint> points = numbered_sweep();
  for (std::size_t i = 1; i < points.size(); i += 2) {
    points[i].x_m = std::nanf("");
    points[i].t_ns = 0;
  }
  const Outcome outcome =
      run("swp", folder.write("a.swp", swp_bytes(points, kSweptRows, kSweptColumns)), folder.file("out.lcm"));
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.returns.used == kSweptRows * kSweptColumns / 2);
  CHECK(outcome.report.returns.no_return == kSweptRows * kSweptColumns / 2);
}

TEST_CASE("times that cannot be cost their own point alone, and have a counter each") {
  struct TimeDamage {
    const char* what;
    std::function<void(std::vector<SweptPoint>&)> plant;
    std::uint64_t ReturnCounts::*counter;
    std::uint32_t row, column;  // of the point that goes
  };
  const TimeDamage damages[] = {
      {"negative", [](auto& p) { point_at(p, 1, 5).t_ns = static_cast<std::uint32_t>(-20'000); },
       &ReturnCounts::time_negative, 1, 5},
      {"beyond the turn", [](auto& p) { point_at(p, 1, 5).t_ns = 97'000'000; }, &ReturnCounts::time_beyond, 1,
       5},
      {"ahead of the next", [](auto& p) { point_at(p, 1, 5).t_ns = 90'000'000; },
       &ReturnCounts::time_unsorted, 1, 5},
      {"ahead of all, first", [](auto& p) { point_at(p, 1, 0).t_ns = 90'000'000; },
       &ReturnCounts::time_unsorted, 1, 0},
      {"behind the one before", [](auto& p) { point_at(p, 2, 40).t_ns = 1'000'000; },
       &ReturnCounts::time_unsorted, 2, 40},
      {"behind, last", [](auto& p) { point_at(p, 3, 63).t_ns = 5; }, &ReturnCounts::time_unsorted, 3, 63},
  };
  const TempFolder folder;
  for (const TimeDamage& damage : damages) {
    INFO(damage.what);
    std::vector<SweptPoint> points = numbered_sweep();
    damage.plant(points);
    const std::string out = folder.file("out.lcm");
    const Outcome outcome =
        run("swp", folder.write("a.swp", swp_bytes(points, kSweptRows, kSweptColumns)), out);
    REQUIRE(outcome.error.empty());
    CHECK(outcome.report.returns.*damage.counter == 1);
    CHECK(outcome.report.returns.used == kSweptRows * kSweptColumns - 1);
    CHECK(outcome.report.warnings.size() == 2);
    const Log log = read_log(out);
    REQUIRE(log.points[0].size() == kSweptRows * kSweptColumns - 1);
    for (const rt::ScanPoint& point : log.points[0]) {
      const bool gone =
          point.x_m == static_cast<float>(damage.column) && point.y_m == static_cast<float>(damage.row);
      CHECK_FALSE(gone);
      CHECK(point.age_10us == 150 * (kSweptColumns - 1 - static_cast<std::uint32_t>(point.x_m)));
    }
    std::filesystem::remove(out);
  }
}

TEST_CASE("a sweep without a usable time is refused whole, and so is a damaged head") {
  const TempFolder folder;
  const std::string out = folder.file("out.lcm");
  const auto refused = [&](std::vector<SweptPoint> points, std::uint32_t columns, const char* says) {
    const auto rows = static_cast<std::uint32_t>(points.size() / columns);
    const Outcome outcome = run("swp", folder.write("a.swp", swp_bytes(points, rows, columns)), out);
    INFO(outcome.error << outcome.notes);
    CHECK(outcome.exit_code == 3);
    CHECK(outcome.error.find(says) != std::string::npos);
  };
  std::vector<SweptPoint> points = numbered_sweep();
  for (SweptPoint& point : points) point.t_ns = 7;
  refused(points, kSweptColumns, "do not rise");
  points = numbered_sweep();
  for (std::size_t i = 0; i < points.size(); ++i) points[i].t_ns = static_cast<std::uint32_t>(i * 40'000'000);
  refused(points, kSweptColumns, "longer than 655.35 ms");
  refused(numbered_sweep(), 1, "do not rise");
  points = numbered_sweep();
  for (SweptPoint& point : points) point.x_m = std::nanf("");
  refused(points, kSweptColumns, "no point of it is a return");
  points = numbered_sweep();
  for (std::size_t i = 0; i < points.size(); i += 3) points[i].t_ns = static_cast<std::uint32_t>(-5);
  refused(points, kSweptColumns, "points have times that cannot be");
  const auto fails = [&](const std::string& bytes, int code, const char* says) {
    const Outcome outcome = run("swp", folder.write("a.swp", bytes), out);
    INFO(outcome.error);
    CHECK(outcome.exit_code == code);
    CHECK(outcome.error.find(says) != std::string::npos);
  };
  fails("SWP1", 3, "the head is damaged");
  fails(swp_bytes({}, 0, 5), 3, "the head is damaged");
  fails(swp_bytes({}, 4'000'000'000u, 4'000'000'000u), 3, "not one row");
  fails("RLS1", 3, "does not begin with 'SWP1'");
}

TEST_CASE("of a cut sweep the whole rows are used, at any byte") {
  const TempFolder folder;
  const std::string out = folder.file("out.lcm");
  const std::string whole = swp_bytes(numbered_sweep(), kSweptRows, kSweptColumns);
  for (std::size_t cut = 12; cut < whole.size(); cut += 61) {
    const Outcome outcome = run("swp", folder.write("a.swp", whole.substr(0, cut)), out);
    const std::size_t rows = (cut - 12) / (16 * kSweptColumns);
    INFO("cut at " << cut << ": " << outcome.error);
    if (rows == 0) {
      CHECK(outcome.exit_code == 3);
      continue;
    }
    REQUIRE(outcome.error.empty());
    CHECK(outcome.report.returns.used == rows * kSweptColumns);
    CHECK(outcome.report.warnings.at(1).find("byte " + std::to_string(12 + rows * 16 * kSweptColumns)) !=
          std::string::npos);
    std::filesystem::remove(out);
  }
}

TEST_CASE("several sweeps have their times as names, a bad one among them is one bad row") {
  const TempFolder folder;
  const std::string out = folder.file("out.lcm");
  for (const char* name : {"9.5.swp", "10.25.swp", "1725981134.252907038.swp", "11.swp", "12.swp"})
    folder.write(name, swp_bytes(numbered_sweep(), kSweptRows, kSweptColumns));
  std::vector<SweptPoint> still = numbered_sweep();
  for (SweptPoint& point : still) point.t_ns = 0;
  folder.write("13.swp", swp_bytes(still, kSweptRows, kSweptColumns));
  const Outcome outcome = run("swp", folder.path(), out);
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.bad_rows == 1);
  CHECK(outcome.notes.find("13.swp: dropped: the times") != std::string::npos);
  const Log log = read_log(out);
  REQUIRE(log.scans.size() == 5);
  const std::int64_t turn_ns = std::int64_t{kSweptStep_ns} * (kSweptColumns - 1);
  CHECK(log.scans[0].stamp_ns == 9'500'000'000 + turn_ns);
  CHECK(log.scans[1].stamp_ns == 10'250'000'000 + turn_ns);
  CHECK(log.scans[4].stamp_ns == 1'725'981'134'252'907'038 + turn_ns);
  std::filesystem::remove(out);
  folder.write("room.swp", swp_bytes(numbered_sweep(), kSweptRows, kSweptColumns));
  const Outcome unnamed = run("swp", folder.path(), out);
  CHECK(unnamed.exit_code == 2);
  CHECK(unnamed.error.find("room.swp: one of several sweeps") != std::string::npos);
}

TEST_CASE("a sweep taken on the move comes in with the motion beside it and is straightened by it") {
  const TempFolder folder;
  // Walls at x = +-6 m and y = +-6 m, seen by a lidar that is carried along.
  constexpr double kStart_s = 2.0;
  std::vector<SweptPoint> points;
  for (std::uint32_t i = 0; i < kSweptRows; ++i) {
    for (std::uint32_t j = 0; j < kSweptColumns; ++j) {
      const mapping::StampedPose body = driven_bend(kStart_s + 1e-9 * j * kSweptStep_ns);
      const double angle = 2.0 * kHalfTurn_rad * j / kSweptColumns + 0.01 * i;
      const rt::Vector3 ray{std::cos(angle), std::sin(angle), 0.05 * i};
      const rt::Vector3 d = rt::rotate(body.q, ray);
      const double to_x = ((d.x > 0 ? 6.0 : -6.0) - body.p.x) / d.x;
      const double to_y = ((d.y > 0 ? 6.0 : -6.0) - body.p.y) / d.y;
      const double r = std::min(to_x, to_y);
      points.push_back({static_cast<float>(r * ray.x), static_cast<float>(r * ray.y),
                        static_cast<float>(r * ray.z), j * kSweptStep_ns});
    }
  }
  folder.write("2.0.swp", swp_bytes(points, kSweptRows, kSweptColumns));
  std::ostringstream odometry;
  odometry.precision(17);
  odometry << "t_s,x_m,y_m,z_m,qx,qy,qz,qw\n";
  for (int k = 0; k <= 250; ++k) {
    const mapping::StampedPose body = driven_bend(0.01 * k);
    odometry << 0.01 * k << ',' << body.p.x << ',' << body.p.y << ',' << body.p.z << ',' << body.q.x << ','
             << body.q.y << ',' << body.q.z << ',' << body.q.w << '\n';
  }
  folder.write("odom.csv", odometry.str());
  const Outcome outcome = run("swp", folder.path(), folder.file("out.lcm"), true);
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.warnings.empty());
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.scans.size() == 1);
  REQUIRE(log.tracks.size() == 251);

  std::vector<rt::ScanPoint> memory(kSweptRows * kSweptColumns);
  mapping::SweepConfig config;
  mapping::Sweeps sweeps(config, memory);
  for (const ReckonedPose& pose : reckon(log))
    REQUIRE(sweeps.add(mapping::StampedPose{pose.stamp_ns, pose.p_m, pose.q}) == Status::ok);
  rt::PointScan scan{log.scans[0], log.points[0].data()};
  const mapping::StraightSweep straight = sweeps.straighten(scan);
  REQUIRE(straight.status == Status::ok);
  REQUIRE(straight.counts.used == kSweptRows * kSweptColumns);
  const auto worst = [&](const rt::ScanPoint* from) {
    double most_m = 0.0;
    for (std::uint32_t i = 0; i < kSweptRows * kSweptColumns; ++i) {
      const rt::Vector3 seen{static_cast<double>(from[i].x_m), static_cast<double>(from[i].y_m),
                             static_cast<double>(from[i].z_m)};
      const rt::Vector3 p = straight.pose.p + rt::rotate(straight.pose.q, seen);
      most_m = std::max(most_m, std::min(std::fabs(std::fabs(p.x) - 6.0), std::fabs(std::fabs(p.y) - 6.0)));
    }
    return most_m;
  };
  CHECK(worst(straight.scan.points) < 1e-3);
  CHECK(worst(log.points[0].data()) > 0.05);  // as it was taken
}
