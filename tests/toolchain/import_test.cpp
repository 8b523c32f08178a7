// SPDX-License-Identifier: BSD-3-Clause
// What importers do with good and damaged rows, shown on the husky files (tables of numbers).
#include <algorithm>
#include <cmath>

#include "rt/rotation.hpp"
#include "tests/toolchain/import_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {
constexpr const char* kImuHead = "t_rx,t_stamp,wx,wy,wz,ax,ay,az,qx,qy,qz,qw\n";
constexpr const char* kOdomHead = "t_rx,t_stamp,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz\n";
constexpr const char* kGpsHead = "t_rx,t_stamp,status,lat,lon,alt,cov_e,cov_n,cov_u\n";

std::string imu_row(int k, const std::string& wx = "0.01") {
  const std::string t = "100." + std::to_string(100000 + 1000 * k);
  return t + "," + t + "," + wx + ",0.02,0.03,1,2,3,0,0,0,1\n";
}

/// A husky set of `rows` rows a file, straight on at 1 m/s.
void write_husky(const TempFolder& folder, int rows, const std::string& imu_override = "") {
  std::string imu = kImuHead;
  std::string odom = kOdomHead;
  std::string gps = kGpsHead;
  for (int k = 0; k < rows; ++k) {
    imu += imu_row(k);
    const std::string t = "100." + std::to_string(100000 + 1000 * k);
    odom += t + "," + t + "," + std::to_string(0.001 * k) + ",5,0,0,0,0,1,1,0,0,0,0,0\n";
    gps += t + "," + t + ",0,42.0,-71.0,7,1,1,1\n";
  }
  folder.write("x_imu.csv", imu_override.empty() ? imu : imu_override);
  folder.write("x_odom.csv", odom);
  folder.write("x_gps.csv", gps);
}

}  // namespace

TEST_CASE("a husky row becomes base-frame samples at their stamps, received when they came") {
  const TempFolder folder;
  write_husky(folder, 50);
  const Outcome outcome = run("husky", folder.path(), folder.file("out.lcm"));
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.rows == 150);
  CHECK(outcome.report.events == 151);
  CHECK(outcome.report.bad_rows == 0);
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.imu.size() == 50);
  CHECK(log.seqs_count_from_zero);
  CHECK(log.imu[0].stamp_ns == 100'100'000'000);
  CHECK(log.imu[0].gyr_rad_s[0] == -0.03);
  CHECK(log.imu[0].gyr_rad_s[1] == -0.01);
  CHECK(log.imu[0].gyr_rad_s[2] == 0.02);
  CHECK(log.imu[0].acc_m_s2[2] == 2.0);
  CHECK(log.imu[0].flags == (rt::kImuGyr | rt::kImuAcc));
  CHECK(log.tracks.back().left_m == Approx(0.049));
  CHECK(log.tracks.back().right_m == Approx(0.049));
  CHECK(log.truth[3].flags == rt::kTruthPosition);
  CHECK_FALSE(log.header.has_ticks);
  CHECK(log.header.epoch_ns == 100'100'000'000);
  CHECK(log.header.source == "husky x_imu.csv x_odom.csv x_gps.csv");
}

TEST_CASE("driving backwards and turning show in the travel of the sides") {
  const TempFolder folder;
  write_husky(folder, 3);
  // Heading north: 1 m forwards, 0.4 m backwards, then a quarter turn to the left on the spot.
  const std::string north = ",0,0,0,0.7071067811865476,0.7071067811865476,0,0,0,0,0,0\n";
  const std::string west = ",0,0,0,1,0,0,0,0,0,0,0\n";
  folder.write("x_odom.csv", std::string(kOdomHead) + "100.1,100.1,5,1" + north + "100.2,100.2,5,2" + north +
                                 "100.3,100.3,5,1.6" + north + "100.4,100.4,5,1.6" + west);
  REQUIRE(run("husky", folder.path(), folder.file("out.lcm")).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.tracks.size() == 4);
  CHECK(log.tracks[1].left_m == Approx(1.0));
  CHECK(log.tracks[2].left_m == Approx(0.6));
  CHECK(log.tracks[2].right_m == Approx(0.6));
  const double half_turn = 0.5 * 1.07 * std::acos(0.0);
  CHECK(log.tracks[3].left_m == Approx(0.6 - half_turn));
  CHECK(log.tracks[3].right_m == Approx(0.6 + half_turn));
}

TEST_CASE("the rotation into the husky's base is yaw -90, roll +90 degrees") {
  const TempFolder folder;
  write_husky(folder, 3);
  REQUIRE(run("husky", folder.file("x_odom.csv"), folder.file("out.lcm")).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  const rt::Vector3 turned =
      rt::rotate(rt::from_yaw_pitch_roll(-std::acos(0.0), 0.0, std::acos(0.0)), {1, 2, 3});
  CHECK(log.imu[0].acc_m_s2[0] == Approx(turned.x));
  CHECK(log.imu[0].acc_m_s2[1] == Approx(turned.y));
  CHECK(log.imu[0].acc_m_s2[2] == Approx(turned.z));
}

TEST_CASE("events are sorted by receipt though stamps are older, and none is received before its stamp") {
  const TempFolder folder;
  std::string imu = kImuHead;
  for (int k = 0; k < 10; ++k) {
    imu += "100." + std::to_string(1350000001 + 10000000 * k).substr(1) + ",100." +
           std::to_string(1000000 + 10000 * k).substr(1) + ",0,0,0,0,9.8,0,0,0,0,1\n";
  }
  write_husky(folder, 100, imu);
  REQUIRE(run("husky", folder.path(), folder.file("out.lcm")).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  CHECK(std::is_sorted(log.receipts_us.begin(), log.receipts_us.end()));
  CHECK(log.imu[0].stamp_ns == 100'000'000'000);
  CHECK(std::count(log.receipts_us.begin(), log.receipts_us.end(), 100'350'001) == 1);  // rounded up
}

TEST_CASE("a NaN in a sensor row drops the row, counts it and prints its line") {
  const TempFolder folder;
  std::string imu = kImuHead;
  for (int k = 0; k < 40; ++k)
    imu += imu_row(k, k == 7 ? "nan" : k == 9 ? "abc" : k == 11 ? "inf" : k == 13 ? "1e300" : "0.01");
  write_husky(folder, 40, imu);
  const Outcome outcome = run("husky", folder.path(), folder.file("out.lcm"));
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.bad_rows == 4);
  CHECK(outcome.report.imu == 36);
  for (const char* part :
       {"x_imu.csv:9: dropped: 'wx' is 'nan', not finite", "x_imu.csv:11: dropped: 'wx' is 'abc', no number",
        "x_imu.csv:13: dropped: 'wx' is 'inf', not finite",
        "x_imu.csv:15: dropped: 'wx' is '1e300', beyond 1e12"}) {
    INFO(outcome.notes);
    CHECK(outcome.notes.find(part) != std::string::npos);
  }
  for (const rt::ImuSample& sample : read_log(folder.file("out.lcm")).imu)
    CHECK(std::isfinite(sample.gyr_rad_s[1]));
}

TEST_CASE("a damaged column that nobody needs still drops the row") {
  const TempFolder folder;
  std::string imu = kImuHead;
  for (int k = 0; k < 40; ++k) imu += imu_row(k);
  imu.replace(imu.rfind(",0,0,0,1\n"), 9, ",0,nan,0,1\n");
  write_husky(folder, 40, imu);
  CHECK(run("husky", folder.path(), folder.file("out.lcm")).report.bad_rows == 1);
}

TEST_CASE("more than a fifth of bad rows is an error, a fifth is not") {
  const TempFolder folder;
  for (const int bad : {20, 21, 30}) {
    std::string imu = kImuHead;
    for (int k = 0; k < 100; ++k) imu += imu_row(k, k % 100 < bad ? "nan" : "0.01");
    write_husky(folder, 100, imu);
    const Outcome outcome = run("husky", folder.path(), folder.file("out.lcm"));
    INFO(bad << " bad rows: " << outcome.error);
    CHECK(outcome.exit_code == (bad > 20 ? 3 : 0));
    if (bad == 30) {
      CHECK(outcome.error.find("30 of 100 rows") != std::string::npos);
      CHECK(outcome.error.find("x_imu.csv:2") != std::string::npos);
      // 20 lines and a total: a bad file does not flood the terminal.
      CHECK(std::count(outcome.notes.begin(), outcome.notes.end(), '\n') == 21);
    }
    std::filesystem::remove(folder.file("out.lcm"));
  }
}

TEST_CASE("with strict one bad row is an error with its line") {
  const TempFolder folder;
  std::string imu = kImuHead;
  for (int k = 0; k < 40; ++k) imu += imu_row(k, k == 7 ? "nan" : "0.01");
  write_husky(folder, 40, imu);
  const Outcome outcome = run("husky", folder.path(), folder.file("out.lcm"), true);
  CHECK(outcome.exit_code == 3);
  CHECK(outcome.error.find("x_imu.csv:9: 'wx' is 'nan'") != std::string::npos);
}

TEST_CASE("a NaN in a truth column is legal, even with strict") {
  const TempFolder folder;
  write_husky(folder, 10);
  folder.write("x_gps.csv", std::string(kGpsHead) +
                                "100.1,100.1,0,nan,-71,7,1,1,1\n100.2,100.2,-1,42,-71,7,1,1,1\n" +
                                "100.3,100.3,0,42,-71,,1,nan,1\n100.4,100.4,0,42.001,-71,7,1,1,1\n");
  const Outcome outcome = run("husky", folder.path(), folder.file("out.lcm"), true);
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.hidden_truth == 2);
  CHECK(outcome.report.bad_rows == 0);
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.truth.size() == 2);
  CHECK(log.truth[1].p_world_body_m[1] == Approx(111.08));
}

TEST_CASE("a cut file keeps what is whole and says the byte") {
  const TempFolder folder;
  std::string imu = kImuHead;
  for (int k = 0; k < 40; ++k) imu += imu_row(k);
  const std::size_t last_row = imu.rfind('\n', imu.size() - 2) + 1;
  write_husky(folder, 40, imu.substr(0, imu.size() - 5));
  const Outcome outcome = run("husky", folder.path(), folder.file("out.lcm"));
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.imu == 39);
  REQUIRE(outcome.report.warnings.size() == 1);
  CHECK(outcome.report.warnings[0].find("byte " + std::to_string(last_row)) != std::string::npos);
  std::filesystem::remove(folder.file("out.lcm"));
  CHECK(run("husky", folder.path(), folder.file("out.lcm"), true).exit_code == 3);
}

TEST_CASE("time that runs backwards is reported and kept") {
  const TempFolder folder;
  std::string imu = kImuHead;
  for (int k = 0; k < 40; ++k) imu += imu_row(k == 20 ? 5 : k);
  write_husky(folder, 40, imu);
  const Outcome outcome = run("husky", folder.path(), folder.file("out.lcm"));
  CHECK(outcome.report.time_backwards == 1);
  CHECK(outcome.report.imu == 40);
  REQUIRE(outcome.report.warnings.size() == 1);
  CHECK(outcome.report.warnings[0].find("x_imu.csv:22: time runs back by 0.014") != std::string::npos);
}

TEST_CASE("missing files, wrong kinds and unknown kinds are named with a cure") {
  const TempFolder folder;
  write_husky(folder, 5);
  const std::string out = folder.file("out.lcm");
  const auto fails = [&](const std::string& kind, const std::string& path, int code,
                         const std::string& part) {
    const Outcome outcome = run(kind, path, out);
    INFO(outcome.error);
    CHECK(outcome.exit_code == code);
    CHECK(outcome.error.find(part) != std::string::npos);
  };
  fails("husky", folder.file("nowhere"), 3, "no such file or folder");
  fails("rls", folder.file("x_imu.csv"), 3, "does not begin with 'RLS1'");
  fails("rls", folder.path(), 3, "holds no *.rls");
  fails("broad", folder.write("y.imu", "RLS1xxxx"), 3, "does not begin with 'IMU1'");
  fails("plaza", folder.path(), 3, "holds no *_DR.txt");
  fails("foo", folder.path(), 2, "husky, plaza, broad, rls, carmen or swp");
  fails("husky", folder.write("z_imu.csv", "a,b,c\n1,2,3\n"), 3,
        "z_imu.csv:1: is not the IMU file of a husky set");
  fails("husky", folder.path(), 2, "2 husky data sets");
  std::filesystem::remove(folder.file("z_imu.csv"));
  fails("husky", folder.write("x_imu.csv", ""), 3, "has no column 't_rx'");
  fails("husky", folder.write("x_imu.csv", kImuHead), 3, "x_imu.csv: holds no whole row");
  std::filesystem::remove(folder.file("x_odom.csv"));
  folder.write("x_imu.csv", kImuHead + imu_row(1));
  fails("husky", folder.path(), 3, "x_odom.csv: no such file");
  fails("plaza", folder.write("p_DR.txt", "1 2 3 4\n1 2 3 4\n"), 3,
        "p_DR.txt:1: is not the dead-reckoning file");
}

TEST_CASE("a log that cannot be written is an input error with the path") {
  const TempFolder folder;
  write_husky(folder, 5);
  const Outcome outcome = run("husky", folder.path(), folder.file("no/such/folder/out.lcm"));
  CHECK(outcome.exit_code == 3);
  CHECK(outcome.error.find("no/such/folder") != std::string::npos);
}
