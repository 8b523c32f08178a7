// SPDX-License-Identifier: BSD-3-Clause
// The recorded data sets: what must come out of them, judged by a dead reckoning written here again.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "rt/rotation.hpp"
#include "tests/toolchain/import_support.hpp"
#include "toolchain/judge/evaluate.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {
std::string data(const std::string& name) { return std::string(SORTIE_DATA_DIR) + "/" + name; }

bool absent(const std::string& path) {
  if (std::filesystem::exists(path)) return false;
  WARN("skipped: no recorded data at " << path);
  return true;
}

/// Plain dead reckoning, written here again: heading from gyro z, travel from the mean of the sides.
Trajectory dead_reckoning(const Log& log) {
  Trajectory path;
  const double yaw_0 = rt::yaw_of(rt::to_quaternion(log.header.initial_q));
  std::vector<double> headings{yaw_0};
  for (std::size_t i = 1; i < log.imu.size(); ++i) {
    const double dt = rt::to_seconds(log.imu[i].stamp_ns - log.imu[i - 1].stamp_ns);
    const bool mean = (log.imu[i].flags & rt::kImuMeanRate) != 0;
    const double now = log.imu[i].gyr_rad_s[2];
    headings.push_back(headings.back() + dt * (mean ? now : 0.5 * (now + log.imu[i - 1].gyr_rad_s[2])));
  }
  const auto heading_at = [&](std::int64_t stamp) {
    const auto after =
        std::lower_bound(log.imu.begin(), log.imu.end(), stamp,
                         [](const rt::ImuSample& s, std::int64_t t) { return s.stamp_ns < t; });
    if (after == log.imu.end()) return headings.back();
    const auto i = static_cast<std::size_t>(after - log.imu.begin());
    if (i == 0) return headings[0];
    const double u = rt::to_seconds(stamp - log.imu[i - 1].stamp_ns) /
                     rt::to_seconds(log.imu[i].stamp_ns - log.imu[i - 1].stamp_ns);
    return headings[i - 1] + u * (headings[i] - headings[i - 1]);
  };
  double x = log.header.initial_p[0];
  double y = log.header.initial_p[1];
  for (std::size_t i = 0; i < log.tracks.size(); ++i) {
    if (i > 0) {
      const auto& a = log.tracks[i - 1];
      const auto& b = log.tracks[i];
      const double d = 0.5 * (b.left_m + b.right_m - a.left_m - a.right_m);
      const double h = heading_at((a.stamp_ns + b.stamp_ns) / 2);
      x += d * std::cos(h);
      y += d * std::sin(h);
    }
    TimedPose pose;
    pose.stamp_ns = log.tracks[i].stamp_ns;
    pose.p[0] = x;
    pose.p[1] = y;
    path.push_back(pose);
  }
  return path;
}

Trajectory truth_of(const Log& log) {
  Trajectory truth;
  for (const rt::TruthSample& sample : log.truth) truth.push_back(to_timed_pose(sample));
  return truth;
}

}  // namespace

TEST_CASE("the recorded husky run imports, and dead reckoning on it comes within 3.3 m of the GPS") {
  const std::string path = data("husky_skid");
  if (absent(path)) return;
  const TempFolder folder;
  const Outcome outcome = run("husky", path, folder.file("out.lcm"), true);
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.imu == 6003);
  CHECK(outcome.report.tracks == 1998);
  CHECK(outcome.report.truth == 500);
  CHECK(outcome.report.warnings.empty());
  const Log log = read_log(folder.file("out.lcm"));
  EvaluationOptions options;
  options.align = Alignment::se2;
  auto errors = evaluate(dead_reckoning(log), truth_of(log), options).errors;
  CHECK(errors["ate_rmse_m"] <= 3.3);
  CHECK(errors["ate_rmse_m"] >= 3.0);  // below the noise of the GPS something would be wrong with the figure
  CHECK(errors["ate_n"] >= 498);
  const auto& last = log.tracks.back();
  CHECK(0.5 * (last.left_m + last.right_m) == Approx(195.5).margin(0.5));
}

TEST_CASE("the recorded plaza run imports, and dead reckoning on it comes within 2.0 m of the truth") {
  const std::string path = data("plaza_odom");
  if (absent(path)) return;
  const TempFolder folder;
  REQUIRE(run("plaza", path, folder.file("out.lcm"), true).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  auto errors = evaluate(dead_reckoning(log), truth_of(log)).errors;
  CHECK(errors["ate_rmse_m"] <= 2.0);
  CHECK(errors["ate_max_m"] == Approx(4.45).margin(0.05));
  CHECK(log.tracks.back().left_m == Approx(1861.28).margin(0.05));
}

namespace {

/// What a CARMEN log holds, read here again by other means.
struct CarmenTwin {
  struct Driven {
    double way_m, heading_rad;
  };
  std::multimap<std::int64_t, Driven> at;               // by the stamp in us
  std::multimap<std::int64_t, std::size_t> below_50_m;  // readings of a scan, by its stamp in us
  std::uint64_t readings{}, odometry_rows{};
  double x_m{}, y_m{}, path_m{};
};

CarmenTwin read_carmen(const std::string& path) {
  CarmenTwin twin;
  std::ifstream file(path);
  double way = 0.0;
  double last_heading = 0.0;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string name;
    words >> name;
    if (name == "ODOM") {
      double x = 0.0, y = 0.0, heading = 0.0, skipped = 0.0, stamp_s = 0.0;
      words >> x >> y >> heading >> skipped >> skipped >> skipped >> stamp_s;
      if (twin.odometry_rows++ > 0) {
        const double middle =
            last_heading + 0.5 * std::remainder(heading - last_heading, 2.0 * std::acos(-1.0));
        const double dx = x - twin.x_m;
        const double dy = y - twin.y_m;
        const bool back = dx * std::cos(middle) + dy * std::sin(middle) < 0.0;
        way += back ? -std::hypot(dx, dy) : std::hypot(dx, dy);
        twin.path_m += std::hypot(dx, dy);
      }
      twin.x_m = x;
      twin.y_m = y;
      last_heading = heading;
      twin.at.insert({std::llround(stamp_s * 1e6), {way, heading}});
    } else if (name == "FLASER") {
      std::size_t count = 0;
      words >> count;
      std::size_t below = 0;
      for (std::size_t i = 0; i < count; ++i) {
        double range = 0.0;
        words >> range;
        if (range < 50.0) ++below;
      }
      twin.readings += count;
      double skipped = 0.0, stamp_s = 0.0;
      for (int i = 0; i < 6; ++i) words >> skipped;
      words >> stamp_s;
      twin.below_50_m.insert({std::llround(stamp_s * 1e6), below});
    }
  }
  return twin;
}

/// The log against the file: rows and points, and at each track sample way and heading of the file's row.
/// Then how far from the file's end reckoning ends.
void check_carmen(const std::string& name, std::uint64_t scans, std::uint64_t odometry, std::uint64_t told,
                  std::uint64_t backwards) {
  const TempFolder folder;
  const Outcome outcome = run("carmen", data("radish_2d/" + name), folder.file("out.lcm"), true);
  REQUIRE(outcome.error.empty());
  const CarmenTwin twin = read_carmen(data("radish_2d/" + name));
  CHECK(twin.odometry_rows == odometry);
  CHECK(outcome.report.rows == scans + odometry);
  CHECK(outcome.report.scans == scans);
  CHECK(outcome.report.tracks == told);
  CHECK(outcome.report.time_backwards == backwards);
  CHECK(outcome.report.returns.in == twin.readings);
  const Log log = read_log(folder.file("out.lcm"));
  CHECK(std::is_sorted(log.receipts_us.begin(), log.receipts_us.end()));
  REQUIRE(log.points.size() == twin.below_50_m.size());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < log.points.size(); ++i) {
    const auto rows = twin.below_50_m.equal_range((log.scans[i].stamp_ns + 500) / 1000);
    const bool found = std::any_of(rows.first, rows.second,
                                   [&](const auto& row) { return row.second == log.points[i].size(); });
    wrong += found ? 0u : 1u;
  }
  CHECK(wrong == 0);
  const std::vector<ReckonedPose> poses = reckon(log);
  wrong = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto rows = twin.at.equal_range((poses[i].stamp_ns + 500) / 1000);
    const bool found = std::any_of(rows.first, rows.second, [&](const auto& row) {
      return std::fabs(row.second.way_m - log.tracks[i].left_m) < 1e-6 &&
             std::fabs(rt::wrap_angle(row.second.heading_rad - rt::yaw_of(poses[i].q))) < 1e-6;
    });
    wrong += found ? 0u : 1u;
    if (i > 0) wrong += poses[i].stamp_ns > poses[i - 1].stamp_ns ? 0u : 1u;
  }
  CHECK(wrong == 0);
  CHECK(std::hypot(poses.back().p_m.x - twin.x_m, poses.back().p_m.y - twin.y_m) < 0.003 * twin.path_m);
}

}  // namespace

TEST_CASE("the recorded aces drive imports, and reckoning on it ends where its odometry does", "[heavy]") {
  if (absent(data("radish_2d/aces.clf"))) return;
  check_carmen("aces.clf", 7374, 7375, 7374, 0);  // one stamp comes twice
}

TEST_CASE("the recorded intel drive imports although its stamps run back", "[heavy]") {
  if (absent(data("radish_2d/intel.clf"))) return;
  check_carmen("intel.clf", 13631, 26915, 9998, 602 + 631);
}

TEST_CASE("the recorded sweep imports with a time for each point", "[heavy]") {
  if (absent(data("tradr_robot/tradr_os0_128.swp"))) return;
  const TempFolder folder;
  const Outcome outcome = run("swp", data("tradr_robot/tradr_os0_128.swp"), folder.file("out.lcm"), true);
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.returns.used == 94680);
  CHECK(outcome.report.returns.no_return == 36392);
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.scans.size() == 1);
  CHECK(log.scans[0].stamp_ns == 99'850'579);
  CHECK(log.points[0].front().age_10us == 9985);
  CHECK(log.points[0].back().age_10us == 0);
  std::vector<std::uint16_t> ages;
  for (const rt::ScanPoint& point : log.points[0])
    if (ages.empty() || ages.back() != point.age_10us) ages.push_back(point.age_10us);
  CHECK(ages.size() <= 1024);  // sorted by time: one change a column
}

TEST_CASE("all recorded scans and trials import", "[heavy]") {
  if (absent(data("lidar_os64"))) return;
  const TempFolder folder;
  const Outcome scans = run("rls", data("lidar_os64"), folder.file("scans.lcm"), true);
  CHECK(scans.report.scans == 122);
  CHECK(scans.report.warnings.empty());
  const Log log = read_log(folder.file("scans.lcm"));
  CHECK(std::is_sorted(log.receipts_us.begin(), log.receipts_us.end()));
  for (const auto& entry : std::filesystem::directory_iterator(data("broad_imu"))) {
    if (entry.path().extension() != ".imu") continue;
    const Outcome trial = run("broad", entry.path().string(), folder.file("trial.lcm"), true);
    INFO(entry.path() << " " << trial.error);
    CHECK(trial.report.imu == trial.report.rows);
    CHECK(trial.report.truth + trial.report.hidden_truth == trial.report.rows);
    CHECK(trial.report.truth > 40000);
    std::filesystem::remove(folder.file("trial.lcm"));
  }
}
