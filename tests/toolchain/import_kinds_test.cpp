// SPDX-License-Identifier: BSD-3-Clause
// Plaza increments, BROAD records and recorded scans, whole and damaged.
#include <cmath>
#include <cstring>

#include "rt/rotation.hpp"
#include "tests/toolchain/import_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {
void put(std::string& bytes, const void* value, std::size_t size) {
  bytes.append(static_cast<const char*>(value), size);
}
template <class T>
void put(std::string& bytes, T value) {
  put(bytes, &value, sizeof value);
}

std::string imu_file(int records, int bad_from = 0, int bad_to = 0, bool truth_hidden = false) {
  std::string bytes = "IMU1";
  put(bytes, static_cast<std::uint32_t>(records));
  put(bytes, 200.0);
  for (int k = 0; k < records; ++k) {
    float r[17] = {0.1f, 0.2f, 0.3f, 0, 0, 9.81f, 1, 2, 3, 1, 0, 0, 0, 4, 5, 6, k >= 5 ? 1.0f : 0.0f};
    if (k >= bad_from && k < bad_to) r[1] = std::nanf("");
    if (truth_hidden) std::fill(r + 9, r + 16, std::nanf(""));
    put(bytes, r, sizeof r);
  }
  return bytes;
}

std::string rls_file(int scans, double bad_pose_at = -1) {
  std::string bytes = "RLS1";
  put(bytes, static_cast<std::uint32_t>(scans));
  put(bytes, 0.005f);
  for (int k = 0; k < scans; ++k) {
    put(bytes, 10.0 + 0.5 * k);
    const double w = k == bad_pose_at ? 2.0 : 1.0;
    // A quarter turn to the left, at (1, 2, 3).
    const double pose[12] = {0, -1, 0, 1, w, 0, 0, 2, 0, 0, 1, 3};
    put(bytes, pose, sizeof pose);
    put(bytes, std::uint32_t{2});
    put(bytes, std::uint32_t{0});
    const std::int16_t xyz[6] = {200, -400, 32767, -32768, 0, 1};
    put(bytes, xyz, sizeof xyz);
    const std::uint16_t intensity[2] = {7, 65535};
    put(bytes, intensity, sizeof intensity);
  }
  return bytes;
}

}  // namespace

TEST_CASE("plaza increments become mean rates and a travelled sum") {
  const TempFolder folder;
  folder.write("p_DR.txt",
               "  1.0000000000000000e+001\t 5.0e-001\t 1.0e-002\t\r\n 1.02e+001 2.5e-001 -2.0e-002\r\n");
  folder.write("p_GT.csv", "t_s,x_m,y_m,heading_rad\n9.8,1,2,1.5\n10.0,1,2.5,1.51\n10.2,nan,nan,nan\n");
  const Outcome outcome = run("plaza", folder.file("p_DR.txt"), folder.file("out.lcm"));
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.hidden_truth == 1);
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.imu.size() == 3);
  CHECK(log.imu[0].stamp_ns == 9'800'000'000);
  CHECK(log.imu[1].gyr_rad_s[2] == Approx(0.05));
  CHECK(log.imu[2].gyr_rad_s[2] == Approx(-0.1));
  CHECK(log.imu[2].flags == (rt::kImuGyr | rt::kImuMeanRate));
  CHECK(log.tracks[2].left_m == Approx(0.75));
  CHECK(log.header.initial_p[1] == 2.0);
  CHECK(rt::yaw_of(rt::to_quaternion(log.header.initial_q)) == Approx(1.5));
}

TEST_CASE("a BROAD trial gives readings, and truth only where the markers were seen") {
  const TempFolder folder;
  REQUIRE(run("broad", folder.write("a.imu", imu_file(20, 3, 5)), folder.file("out.lcm")).report.bad_rows ==
          2);
  const Log log = read_log(folder.file("out.lcm"));
  CHECK(log.imu.size() == 18);
  REQUIRE(log.truth.size() == 20);
  CHECK(log.imu.back().stamp_ns == 95'000'000);
  CHECK(log.imu[0].gyr_rad_s[2] == static_cast<double>(0.3f));
  CHECK(log.truth[4].flags == (rt::kTruthPosition | rt::kTruthHeight | rt::kTruthOrientation));
  CHECK(log.truth[5].flags ==
        (rt::kTruthPosition | rt::kTruthHeight | rt::kTruthOrientation | rt::kTruthMoving));
  std::filesystem::remove(folder.file("out.lcm"));
  const Outcome hidden =
      run("broad", folder.write("b.imu", imu_file(20, 0, 0, true)), folder.file("out.lcm"), true);
  CHECK(hidden.error.empty());
  CHECK(hidden.report.hidden_truth == 20);
  std::filesystem::remove(folder.file("out.lcm"));
  CHECK(run("broad", folder.write("b.imu", imu_file(20, 0, 6)), folder.file("out.lcm")).exit_code == 3);
  const Outcome cut =
      run("broad", folder.write("b.imu", imu_file(20).substr(0, 16 + 68 * 7 + 30)), folder.file("out.lcm"));
  CHECK(cut.report.imu == 7);
  REQUIRE(cut.report.warnings.size() == 1);
  CHECK(cut.report.warnings[0].find("byte " + std::to_string(16 + 68 * 7)) != std::string::npos);
  std::filesystem::remove(folder.file("out.lcm"));
  CHECK(run("broad", folder.write("b.imu", imu_file(2).substr(0, 9)), folder.file("out.lcm"))
            .error.find("head") != std::string::npos);
}

TEST_CASE("recorded scans keep pose, points and intensity") {
  const TempFolder folder;
  REQUIRE(run("rls", folder.write("a.rls", rls_file(3)), folder.file("out.lcm")).error.empty());
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.scans.size() == 3);
  CHECK(log.scans[1].stamp_ns == 10'500'000'000);
  CHECK(log.scans[1].flags == rt::kScanPosed);
  CHECK(rt::yaw_of(rt::to_quaternion(log.scans[1].q_world_sensor)) == Approx(std::acos(0.0)));
  CHECK(log.scans[1].p_world_sensor_m[2] == 3.0);
  REQUIRE(log.points[2].size() == 2);
  CHECK(log.points[2][0].x_m == 200 * 0.005f);
  CHECK(log.points[2][0].z_m == 32767 * 0.005f);
  CHECK(log.points[2][1].x_m == -32768 * 0.005f);
  CHECK(log.points[2][1].intensity == 65535);
  CHECK(log.header.initial_p[0] == 1.0);
}

TEST_CASE("scans without their poses keep points and stamps, and the poses become truth") {
  const TempFolder folder;
  ImportOptions options{"rls", folder.write("a.rls", rls_file(3)), folder.file("out.lcm")};
  options.no_poses = true;
  const Outcome outcome = run(options);
  REQUIRE(outcome.error.empty());
  CHECK(outcome.report.truth == 3);
  const Log log = read_log(folder.file("out.lcm"));
  REQUIRE(log.scans.size() == 3);
  REQUIRE(log.truth.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(log.scans[k].flags == 0);
    CHECK(log.scans[k].stamp_ns == log.truth[k].stamp_ns);
    for (int i = 0; i < 3; ++i) CHECK(log.scans[k].p_world_sensor_m[i] == 0.0);
    CHECK(log.scans[k].q_world_sensor[0] == 1.0);
    CHECK(log.points[k].size() == 2);
    CHECK(log.truth[k].p_world_body_m[2] == 3.0);
    CHECK(rt::yaw_of(rt::to_quaternion(log.truth[k].q_world_body)) == Approx(std::acos(0.0)));
    CHECK(log.truth[k].flags == (rt::kTruthPosition | rt::kTruthHeight | rt::kTruthOrientation));
  }
  std::filesystem::remove(folder.file("out.lcm"));
  options.kind = "broad";
  const Outcome wrong = run(options);
  CHECK(wrong.exit_code == 2);
  CHECK(wrong.error.find("--no-poses is for kind rls") != std::string::npos);
}

TEST_CASE("damaged scan files: a bad pose is dropped, a cut tail is told, lengths are not trusted",
          "[heavy]") {
  const TempFolder folder;
  const std::string out = folder.file("out.lcm");
  const Outcome bad = run("rls", folder.write("a.rls", rls_file(10, 4)), out);
  CHECK(bad.report.bad_rows == 1);
  CHECK(bad.report.scans == 9);
  CHECK(bad.notes.find("scan 4 at byte " + std::to_string(12 + 4 * 128)) != std::string::npos);
  const std::string whole = rls_file(3);
  for (std::size_t cut = 12; cut < whole.size(); ++cut) {
    std::filesystem::remove(out);
    const Outcome outcome = run("rls", folder.write("a.rls", whole.substr(0, cut)), out);
    const std::size_t scans = (cut - 12) / 128;
    INFO("cut at byte " << cut << ": " << outcome.error);
    if (scans == 0) {
      CHECK(outcome.exit_code == 3);
      CHECK(outcome.error.find("byte 12") != std::string::npos);
    } else {
      REQUIRE(outcome.report.scans == scans);
      REQUIRE(outcome.report.warnings.size() == 1);
      CHECK(outcome.report.warnings[0].find("byte " + std::to_string(12 + 128 * scans)) != std::string::npos);
    }
  }
  std::string huge = whole;
  const std::uint32_t many = 4'000'000'000u;
  std::memcpy(huge.data() + 12 + 104, &many, sizeof many);
  std::filesystem::remove(out);
  CHECK(run("rls", folder.write("a.rls", huge), out).exit_code == 3);
}
