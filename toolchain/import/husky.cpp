// SPDX-License-Identifier: BSD-3-Clause
// Husky A200: IMU at 30 Hz turned into the base, wheel odometry at 10 Hz as travel of the two sides, GPS as
// truth.
#include <cmath>
#include <filesystem>

#include "rt/math.hpp"
#include "rt/rotation.hpp"
#include "toolchain/import/data_set.hpp"
#include "toolchain/import/kinds.hpp"
#include "toolchain/import/number_table.hpp"

namespace sortie::toolchain {
namespace {

/// Distance between the sides that makes wheel travel and turn agree: 0.5708 m between the wheels,
/// times 1.875 because a skid-steered robot slips in turns. Only the mean of the sides enters the odometry.
constexpr double kSideDistance = 1.07;
constexpr double kMetresPerDegreeLatitude = 111080.0;
constexpr double kMetresPerDegreeLongitude = 111320.0;  // at the equator
constexpr double kRadians = 0.017453292519943295;

/// IMU to base: yaw -pi/2, pitch 0, roll +pi/2. Written out, so that no rounding of an angle enters.
void to_base(double x, double y, double z, double (&base)[3]) {
  base[0] = -z;
  base[1] = -x;
  base[2] = y;
}

void read_imu(const std::string& path, RowJudge& judge, LogBuilder& builder) {
  NumberTable table(
      path, {"the IMU file of a husky set", {"t_rx", "t_stamp"}, {"wx", "wy", "wz", "ax", "ay", "az"}},
      judge);
  while (table.next(1)) {
    rt::ImuSample sample;
    sample.stamp_ns = table.nanoseconds(1);
    to_base(table.number(2), table.number(3), table.number(4), sample.gyr_rad_s);
    to_base(table.number(5), table.number(6), table.number(7), sample.acc_m_s2);
    sample.flags = rt::kImuGyr | rt::kImuAcc;
    builder.add(table.nanoseconds(0), sample);
  }
}

/// The robot publishes its own integrated pose. Differences of it give the travel back; they lose nothing
/// when a row is missing.
void read_odometry(const std::string& path, RowJudge& judge, LogBuilder& builder) {
  NumberTable table(
      path, {"the odometry file of a husky set", {"t_rx", "t_stamp"}, {"x", "y", "qx", "qy", "qz", "qw"}},
      judge);
  rt::TrackSample sample;
  double last_x = 0.0;
  double last_y = 0.0;
  double last_yaw = 0.0;
  bool first = true;
  while (table.next(1)) {
    const double x = table.number(2);
    const double y = table.number(3);
    const double yaw =
        rt::yaw_of(rt::normalised({table.number(7), table.number(4), table.number(5), table.number(6)}));
    if (!first) {
      const double dx = x - last_x;
      const double dy = y - last_y;
      const double forward = dx * rt::cos(last_yaw) + dy * rt::sin(last_yaw);
      const double distance = std::sqrt(dx * dx + dy * dy) * (forward < 0.0 ? -1.0 : 1.0);
      const double half_turn = 0.5 * kSideDistance * rt::wrap_angle(yaw - last_yaw);
      sample.left_m += distance - half_turn;
      sample.right_m += distance + half_turn;
    }
    first = false;
    last_x = x;
    last_y = y;
    last_yaw = yaw;
    sample.stamp_ns = table.nanoseconds(1);
    builder.add(table.nanoseconds(0), sample);
  }
}

/// East and north in metres from the first fix. The altitude of a GPS is no truth, so the height is left out.
void read_gps(const std::string& path, RowJudge& judge, LogBuilder& builder) {
  NumberTable table(path,
                    {"the GPS file of a husky set",
                     {"t_rx", "t_stamp"},
                     {"status", "lat", "lon", "alt", "cov_e", "cov_n", "cov_u"},
                     true,
                     true},
                    judge);
  double latitude_0 = 0.0;
  double longitude_0 = 0.0;
  double metres_per_degree = 0.0;
  bool first = true;
  while (table.next(1)) {
    const double latitude = table.number(3);
    const double longitude = table.number(4);
    const bool has_fix = !(table.number(2) < 0.0);  // -1: no fix; absent: taken as good
    if (!has_fix || !(std::fabs(latitude) <= 90.0) || !(std::fabs(longitude) <= 360.0)) {
      judge.hidden_truth();
      continue;
    }
    if (first) {
      latitude_0 = latitude;
      longitude_0 = longitude;
      metres_per_degree = kMetresPerDegreeLongitude * rt::cos(latitude * kRadians);
      first = false;
    }
    rt::TruthSample sample;
    sample.stamp_ns = table.nanoseconds(1);
    sample.p_world_body_m[0] = (longitude - longitude_0) * metres_per_degree;
    sample.p_world_body_m[1] = (latitude - latitude_0) * kMetresPerDegreeLatitude;
    sample.flags = rt::kTruthPosition;
    builder.add(table.nanoseconds(0), sample);
  }
}

}  // namespace

void import_husky(RowJudge& judge, LogBuilder& builder) {
  const std::string front = find_set(judge.options().path, "_imu.csv", {"_odom.csv", "_gps.csv"}, "husky");
  read_imu(front + "_imu.csv", judge, builder);
  read_odometry(front + "_odom.csv", judge, builder);
  if (std::filesystem::exists(front + "_gps.csv")) {
    read_gps(front + "_gps.csv", judge, builder);
  } else {
    judge.warn(front + "_gps.csv: not there; the log has no truth");
  }
}

}  // namespace sortie::toolchain
