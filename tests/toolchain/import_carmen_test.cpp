// SPDX-License-Identifier: BSD-3-Clause
// CARMEN logs: readings become points, the summed-up pose becomes travel and turn, and damage has a name.
#include <algorithm>
#include <cmath>

#include "tests/toolchain/import_support.hpp"
#include "toolchain/import/rising_stamps.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

constexpr double kPi_rad = 3.14159265358979323846;

std::string odom_row(const std::string& pose, const std::string& t) {
  return "ODOM " + pose + " 0 0 0 " + t + " host " + t + "\n";
}

std::string range_list(int count, const std::string& range) {
  std::string text;
  for (int i = 0; i < count; ++i) text += " " + range;
  return text;
}

std::string flaser_row(int count, const std::string& range, const std::string& t) {
  return "FLASER " + std::to_string(count) + range_list(count, range) + " 0 0 0 0 0 0 " + t + " host " + t +
         "\n";
}

/// A drive along x, a row of odometry and one of the laser every 0.1 s.
std::string drive_log(int rows) {
  std::string text = "# a comment\nPARAM robot_frontlaser_offset 0.0 nohost 0\n\n";
  for (int k = 0; k < rows; ++k) {
    const std::string t = "100." + std::to_string(100000 + 1000 * k).substr(1);
    text += odom_row("0.0" + std::to_string(10 + k) + " 5 0", t) + flaser_row(180, "2.5", t);
  }
  return text;
}

}  // namespace

TEST_CASE("readings of a front laser lie half a turn around its axis, by their number") {
  const TempFolder folder;
  for (const int count : {1, 2, 180, 181, 360, 361}) {
    const std::string out = folder.file(std::to_string(count) + ".lcm");
    REQUIRE(run("carmen", folder.write("a.clf", flaser_row(count, "3.25", "7.125")), out).error.empty());
    const Log log = read_log(out);
    REQUIRE(log.scans.size() == 1);
    CHECK(log.scans[0].stamp_ns == 7'125'000'000);
    CHECK(log.scans[0].flags == 0);
    REQUIRE(log.points[0].size() == static_cast<std::size_t>(count));
    const int steps = count % 2 == 1 && count > 1 ? count - 1 : count;
    for (int i = 0; i < count; ++i) {
      const rt::ScanPoint& point = log.points[0][static_cast<std::size_t>(i)];
      const double angle = -kPi_rad / 2 + kPi_rad * i / steps;
      CHECK(static_cast<double>(point.x_m) == Approx(3.25 * std::cos(angle)).margin(1e-6));
      CHECK(static_cast<double>(point.y_m) == Approx(3.25 * std::sin(angle)).margin(1e-6));
      CHECK(point.z_m == 0.0f);
      CHECK(point.age_10us == 0);
    }
  }
}

TEST_CASE("a ROBOTLASER1 row has its own angles, range and remissions") {
  const TempFolder folder;
  const std::string row =
      "ROBOTLASER1 0 -1.0 2.0 0.5 8.0 0.01 0 5 1.0 7.9 8.0 2.0 3.0 2 10 20 9 9 9 1.5 2.5 0.25 0 0 0 0 0 12.5 "
      "host 0.1\n";
  REQUIRE(run("carmen", folder.write("a.log", row), folder.file("out.lcm")).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.points.size() == 1);
  REQUIRE(log.points[0].size() == 4);  // 8.0 is no return
  CHECK(static_cast<double>(log.points[0][0].y_m) == Approx(std::sin(-1.0)));
  CHECK(static_cast<double>(log.points[0][2].y_m) == Approx(2.0 * std::sin(0.5)));
  CHECK(static_cast<double>(log.points[0][3].x_m) == Approx(3.0 * std::cos(1.0)));
  REQUIRE(log.tracks.size() == 1);  // no ODOM row: the laser's rows tell the odometry
  CHECK(log.header.initial_p[0] == 1.5);
  CHECK(rt::yaw_of(rt::to_quaternion(log.header.initial_q)) == Approx(0.25));
}

TEST_CASE("a log without ODOM takes the odometry of its front laser's rows, not the laser's pose") {
  const TempFolder folder;
  const std::string rows = "FLASER 1 2 9 9 9 1 2 0 10 host 0\nFLASER 1 2 9.5 9 9 1.25 2 0 10.5 host 0\n";
  REQUIRE(run("carmen", folder.write("a.clf", rows), folder.file("out.lcm")).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.tracks.size() == 2);
  CHECK(log.header.initial_p[0] == 1.0);
  CHECK(log.header.initial_p[1] == 2.0);
  CHECK(log.tracks[1].left_m == Approx(0.25));
}

TEST_CASE("what is no return is left out and counted, and the range can be chosen") {
  const TempFolder folder;
  const std::string scan = "FLASER 8 0 -1 nan inf 3 49.9 50 81.83 0 0 0 0 0 0 1.5 host 1.5\n";
  struct Trial {
    const char* setting;
    double asked_m;
    std::uint64_t used;
  };
  for (const Trial& trial : {Trial{"", 0.0, 2}, Trial{"PARAM robot_front_laser_max 81.9 host 0\n", 0.0, 4},
                             Trial{"PARAM robot_front_laser_max 81.9 host 0\n", 3.0, 0}, Trial{"", 3.5, 1}}) {
    const std::string out = folder.file("out.lcm");
    ImportOptions options{"carmen", folder.write("a.clf", trial.setting + scan), out};
    options.max_range_m = trial.asked_m;
    const Outcome outcome = run(options);
    INFO(trial.setting << " " << trial.asked_m << ": " << outcome.error);
    REQUIRE(outcome.error.empty());
    const ReturnCounts& returns = outcome.report.returns;
    CHECK(returns.in == 8);
    CHECK(returns.used == trial.used);
    CHECK(returns.not_finite == 2);
    CHECK(returns.out_of_range == 6 - trial.used);
    CHECK(read_log(out).points.at(0).size() == trial.used);
    std::filesystem::remove(out);
  }
}

TEST_CASE("the summed-up pose becomes travel, backwards too, and mean rates that sum up to its turn") {
  const TempFolder folder;
  const std::string log_text = odom_row("1 2 1.5707963267948966", "10") +    // looks along y
                               odom_row("1 3 1.5707963267948966", "10.5") +  // a metre ahead
                               odom_row("1 2.6 1.5707963267948966", "11") +  // and 0.4 m back
                               odom_row("1 2.6 3.1", "11.5") + odom_row("1 2.6 -3.1", "12");  // over the seam
  REQUIRE(run("carmen", folder.write("a.clf", log_text), folder.file("out.lcm")).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.tracks.size() == 5);
  REQUIRE(log.imu.size() == 5);
  CHECK(log.tracks[1].left_m == Approx(1.0));
  CHECK(log.tracks[2].right_m == Approx(0.6));
  CHECK(log.tracks[4].left_m == Approx(0.6));
  CHECK(log.imu[2].gyr_rad_s[2] == Approx(0.0).margin(1e-9));
  CHECK(log.imu[3].gyr_rad_s[2] == Approx(2.0 * (3.1 - kPi_rad / 2)));
  CHECK(log.imu[4].gyr_rad_s[2] == Approx(2.0 * (2.0 * kPi_rad - 6.2)));
  CHECK(log.imu[1].flags == (rt::kImuGyr | rt::kImuMeanRate));
  CHECK(log.header.initial_p[1] == 2.0);
  const ReckonedPose last = reckon(log).back();
  CHECK(last.p_m.x == Approx(1.0));
  CHECK(last.p_m.y == Approx(2.6));
}

TEST_CASE("the longest rise of stamps is as long as that of brute force") {
  std::uint32_t seed = 12345;  // printed by INFO where it fails
  const auto draw = [&seed] { return (seed = seed * 1664525u + 1013904223u) >> 16; };
  for (int trial = 0; trial < 300; ++trial) {
    INFO("trial " << trial);
    std::vector<rt::Nanoseconds> stamps(draw() % 11);
    for (rt::Nanoseconds& stamp : stamps) stamp = draw() % 8;
    std::size_t longest = 0;
    for (std::uint32_t choice = 0; choice < 1u << stamps.size(); ++choice) {
      std::vector<rt::Nanoseconds> chosen;
      for (std::size_t i = 0; i < stamps.size(); ++i)
        if ((choice >> i & 1u) != 0) chosen.push_back(stamps[i]);
      if (std::is_sorted(chosen.begin(), chosen.end())) longest = std::max(longest, chosen.size());
    }
    const std::vector<bool> rises = longest_rise(stamps);
    REQUIRE(rises.size() == stamps.size());
    std::vector<rt::Nanoseconds> found;
    for (std::size_t i = 0; i < stamps.size(); ++i)
      if (rises[i]) found.push_back(stamps[i]);
    CHECK(std::is_sorted(found.begin(), found.end()));
    CHECK(found.size() == longest);
  }
}

TEST_CASE("stamps that run back are counted, and what their rows drove is told with the next") {
  const TempFolder folder;
  const std::string log_text = odom_row("0 0 0", "10") + odom_row("0.1 0 0.1", "10.1") +
                               odom_row("0.2 0 0.2", "10.5") + flaser_row(2, "1", "10.2") +
                               odom_row("0.3 0 0.3", "10.3") + flaser_row(2, "1", "10.1") +
                               odom_row("0.4 0 0.4", "10.5") + odom_row("0.5 0 0.5", "10.6");
  const Outcome outcome = run("carmen", folder.write("a.clf", log_text), folder.file("out.lcm"));
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.time_backwards == 2);
  CHECK(outcome.report.out_of_order == 2);  // the early 10.5 and one of the two scans
  CHECK(outcome.report.bad_rows == 0);
  REQUIRE(outcome.report.warnings.size() == 2);
  CHECK(outcome.report.warnings[0].find("a.clf: 2 rows have stamps out of order") != std::string::npos);
  CHECK(outcome.report.warnings[1].find("a.clf:5: time runs back by 0.2") != std::string::npos);
  const Log log = read_log(folder.file("out.lcm"));
  CHECK(std::is_sorted(log.receipts_us.begin(), log.receipts_us.end()));
  REQUIRE(log.tracks.size() == 5);
  REQUIRE(log.imu.size() == 5);
  CHECK(log.tracks[2].stamp_ns == 10'300'000'000);
  CHECK(log.tracks[2].left_m == Approx(0.1 + 2.0 * 0.1));
  CHECK(log.imu[2].gyr_rad_s[2] == Approx(0.2 / 0.2));
  CHECK(log.tracks[4].left_m == Approx(0.5));
  CHECK(rt::yaw_of(reckon(log).back().q) == Approx(0.5));
  REQUIRE(log.scans.size() == 2);  // as they came, with their own stamps
  CHECK(log.scans[0].stamp_ns == 10'200'000'000);
  CHECK(log.scans[1].stamp_ns == 10'100'000'000);
}

TEST_CASE(
    "a way or turn that nothing could make within 0.1 s is told with the next row, a leap over more is "
    "told") {
  const TempFolder folder;
  const std::string log_text = odom_row("0 0 0", "10") + odom_row("0 0 0.2", "10.000001") +
                               odom_row("0 0 0.2", "10.1") + odom_row("0 0 0.2", "10.2") +
                               odom_row("0.5 0 0.2", "10.201") + odom_row("1 0 0.2", "10.4") +
                               odom_row("9 0 0.2", "10.5");
  REQUIRE(run("carmen", folder.write("a.clf", log_text), folder.file("out.lcm")).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.imu.size() == 5);
  REQUIRE(log.tracks.size() == 5);
  CHECK(log.tracks[2].left_m == 0.0);
  CHECK(log.tracks[3].left_m == Approx(1.0));
  CHECK(log.tracks[4].left_m == Approx(9.0));
  CHECK(log.imu[1].gyr_rad_s[2] == Approx(2.0));
  CHECK(log.imu[2].gyr_rad_s[2] == Approx(0.0).margin(1e-12));
}

TEST_CASE("a wild stamp is dropped, a pause is not") {
  const TempFolder folder;
  const std::string rest = odom_row("0 0 0", "10") + odom_row("0 0 0", "10.1") + odom_row("0 0 0", "500") +
                           odom_row("0 0 0", "500.1") + odom_row("0 0 0", "500.2");
  for (const bool first : {true, false}) {
    const std::string wild = odom_row("0 0 0", "976052857.3");
    const std::string text = first ? wild + rest : rest + wild + odom_row("0 0 0", "500.3");
    const Outcome outcome = run("carmen", folder.write("a.clf", text), folder.file("out.lcm"));
    REQUIRE(outcome.error.empty());
    CHECK(outcome.report.bad_rows == 1);
    CHECK(outcome.report.time_backwards == 0);
    CHECK(outcome.report.tracks == (first ? 5u : 6u));
    CHECK(outcome.notes.find(first ? "a.clf:1: dropped: its stamp" : "a.clf:6: dropped: its stamp") !=
          std::string::npos);
    std::filesystem::remove(folder.file("out.lcm"));
  }
}

TEST_CASE("damaged rows of a CARMEN log are dropped with their line and reason") {
  const TempFolder folder;
  struct Damage {
    std::string row;
    const char* says;
  };
  const Damage damages[] = {
      {"ODOM 0 0 0 0 0 0 100.5 host\n", "9 columns instead of 10"},
      {"ODOM 0 nan 0 0 0 0 100.5 host 0\n", "column 3 is 'nan', not finite"},
      {"ODOM 0 0 0 0 x 0 100.5 host 0\n", "column 6 is 'x', no number"},
      {"ODOM 0 1e8 0 0 0 0 100.5 host 0\n", "column 3 is '1e8', beyond 1e7"},
      {"ODOM 0 0 0 0 0 0 -1 host 0\n", "its stamp is '-1', not within 0 to 9e9 s"},
      {"ODOM 0 0 0 0 0 0 soon host 0\n", "its stamp is 'soon', no time"},
      {"ODOM 0 0 0 0 0 0 100.5 host late\n", "the logger's time is 'late'"},
      {"FLASER\n", "ends before the number of its readings"},
      {"FLASER 3 1 2 0 0 0 0 0 0 100.5 host 0\n", "13 columns instead of 14"},
      {"FLASER 2 1 2 3 0 0 0 0 0 0 100.5 host 0\n", "14 columns instead of 13"},
      {"FLASER 900 1 2 0 0 0 0 0 0 100.5 host 0\n", "'900' readings do not fit into 13 columns"},
      {"FLASER -1 1 0 0 0 0 0 0 100.5 host 0\n", "'-1' is no number of readings"},
      {"FLASER 99999999999999999999999 1 2\n", "is no number of readings"},
      {"FLASER 0 0 0 0 0 0 0 100.5 host 0\n", "it has no reading"},
      {"FLASER 2 1 abc 0 0 0 0 0 0 100.5 host 0\n", "reading 1 is 'abc', no number"},
      {"ROBOTLASER1 0 -1 2 0.5 8 0 0 2 1 1\n", "11 columns instead of"},
      {"ROBOTLASER1 0 -1 2 0.5 8 0 0 1 1 7 0 0 0\n", "14 columns instead of"},
      {"ROBOTLASER1 0 -1 2 5 8 0 0 3 1 1 1 0 9 9 9 1 2 0 0 0 0 0 0 12.5 host 0\n", "within one turn"},
      {"ROBOTLASER1 0 -1 2 nan 8 0 0 1 1 0 9 9 9 1 2 0 0 0 0 0 0 12.5 host 0\n", "column 5 is 'nan'"},
      {"ROBOTLASER1 0 -1 2 0.1 0 0 0 1 1 0 9 9 9 1 2 0 0 0 0 0 0 12.5 host 0\n", "range is not above 0"},
      {"PARAM robot_front_laser_max far host 0\n", "robot_front_laser_max is no length"},
      {"0.5 0.5 0.5 0 0 0 100.5 host 0\n", "'0.5' is no name of a row"},
  };
  for (const Damage& damage : damages) {
    const std::string out = folder.file("out.lcm");
    const Outcome outcome =
        run("carmen", folder.write("a.clf", drive_log(20) + damage.row + drive_log(5)), out);
    INFO(damage.row << outcome.notes << outcome.error);
    CHECK(outcome.report.bad_rows == 1);
    CHECK(outcome.report.scans == 25);
    CHECK(outcome.notes.find("a.clf:44: dropped: ") != std::string::npos);
    CHECK(outcome.notes.find(damage.says) != std::string::npos);
    std::filesystem::remove(out);
    CHECK(run("carmen", folder.file("a.clf"), out, true).exit_code == 3);
  }
}

TEST_CASE("a CARMEN log cut at any byte keeps every whole row, and says where it breaks off") {
  const TempFolder folder;
  const std::string whole = drive_log(2);
  for (std::size_t cut = 0; cut < whole.size(); cut += 7) {
    const std::string out = folder.file("out.lcm");
    const std::string text = whole.substr(0, cut);
    const Outcome outcome = run("carmen", folder.write("a.clf", text), out);
    const std::string lines =
        text.substr(0, text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
    const auto count = [&lines](const std::string& name) {
      std::uint64_t n = 0;
      for (std::size_t at = lines.find("\n" + name); at != std::string::npos;
           at = lines.find("\n" + name, at + 1))
        ++n;
      return n;
    };
    INFO("cut at " << cut << ": " << outcome.error);
    if (count("ODOM ") == 0) {
      CHECK(outcome.exit_code == 3);
      continue;
    }
    REQUIRE(outcome.error.empty());
    CHECK(outcome.report.tracks == count("ODOM "));
    CHECK(outcome.report.scans == count("FLASER "));
    CHECK(outcome.report.bad_rows == 0);
    if (text.back() != '\n') {
      REQUIRE(outcome.report.warnings.size() == 1);
      CHECK(outcome.report.warnings[0].find("byte " + std::to_string(lines.size())) != std::string::npos);
    }
    std::filesystem::remove(out);
  }
}

TEST_CASE("rows of other kinds are counted by name, a laser off the middle is told, a wrong file refused") {
  const TempFolder folder;
  const std::string out = folder.file("out.lcm");
  const std::string others =
      "SYNC start 1 host 1\nRLASER 1 2 0 0 0 0 0 0 1 host 1\nRLASER 1 2 0 0 0 0 0 0 1 host 1\n"
      "PARAM robot_frontlaser_offset 0.125 host 0\n";
  const Outcome outcome = run("carmen", folder.write("a.clf", others + drive_log(3)), out, true);
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.other_rows == 3);
  REQUIRE(outcome.report.warnings.size() == 1);
  CHECK(outcome.report.warnings[0].find("RLASER 2, SYNC 1") != std::string::npos);
  const std::string off =
      "PARAM robot_frontlaser_offset 0.125 host 0\n" + drive_log(1).substr(drive_log(1).find("ODOM"));
  const Outcome told = run("carmen", folder.write("b.clf", off), folder.file("b.lcm"));
  REQUIRE(told.report.warnings.size() == 1);
  CHECK(told.report.warnings[0].find("0.125 m ahead") != std::string::npos);
  std::filesystem::remove(out);
  const Outcome wrong = run("carmen", folder.write("x.csv", "t_rx,t_stamp\n1,2\n"), out);
  CHECK(wrong.exit_code == 3);
  CHECK(wrong.error.find("none of its 2 lines begins with ODOM") != std::string::npos);
  CHECK(run("carmen", folder.path(), out).exit_code == 2);
  ImportOptions options{"plaza", folder.path(), out};
  options.max_range_m = 5.0;
  CHECK(run(options).error.find("--max-range is for kind carmen") != std::string::npos);
}
