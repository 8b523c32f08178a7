// SPDX-License-Identifier: BSD-3-Clause
// Plaza: rows of travelled distance and turned angle since the row before. Increments, so the gyro samples
// are means.
#include <cmath>
#include <filesystem>

#include "rt/rotation.hpp"
#include "toolchain/import/data_set.hpp"
#include "toolchain/import/kinds.hpp"
#include "toolchain/import/number_table.hpp"

namespace sortie::toolchain {
namespace {

/// Row k of the file speaks of the time from row k-1 to row k. Where there is no row before, one period of
/// the mower's 5 Hz is assumed.
constexpr rt::Nanoseconds kPeriod = 200'000'000;

struct Start {
  bool known{false};
  rt::Nanoseconds stamp_ns{};
};

/// The truth's heading is the same gyro integrated, so it is no truth and is used only as the initial
/// heading.
Start read_truth(const std::string& path, RowJudge& judge, LogBuilder& builder) {
  NumberTable table(
      path, {"the truth file of a plaza set", {"t_s"}, {"x_m", "y_m", "heading_rad"}, true, true}, judge);
  Start start;
  while (table.next(0)) {
    const double x = table.number(1);
    const double y = table.number(2);
    const double heading = table.number(3);
    if (std::isnan(x) || std::isnan(y)) {
      judge.hidden_truth();
      continue;
    }
    if (!start.known && !std::isnan(heading)) {
      start = {true, table.nanoseconds(0)};
      double q[4]{};
      rt::store(rt::from_yaw_pitch_roll(heading, 0.0, 0.0), q);
      builder.set_initial_pose({x, y, 0.0}, q);
    }
    rt::TruthSample sample;
    sample.stamp_ns = table.nanoseconds(0);
    sample.p_world_body_m[0] = x;
    sample.p_world_body_m[1] = y;
    sample.flags = rt::kTruthPosition;
    builder.add(sample.stamp_ns, sample);
  }
  return start;
}

void add_pair(LogBuilder& builder, rt::Nanoseconds stamp_ns, double rate_rad_s, double travel_m) {
  rt::ImuSample imu;
  imu.stamp_ns = stamp_ns;
  imu.gyr_rad_s[2] = rate_rad_s;
  imu.flags = rt::kImuGyr | rt::kImuMeanRate;
  builder.add(stamp_ns, imu);  // before the track sample of the same time: its heading is needed there
  rt::TrackSample track;
  track.stamp_ns = stamp_ns;
  track.left_m = travel_m;  // the file knows only the travel of the centre
  track.right_m = travel_m;
  builder.add(stamp_ns, track);
}

void read_increments(const std::string& path, const Start& start, RowJudge& judge, LogBuilder& builder) {
  NumberTable table(
      path, {"the dead-reckoning file of a plaza set", {"t"}, {"distance", "heading_increment"}, false},
      judge);
  double travel_m = 0.0;
  rt::Nanoseconds last_ns = 0;
  bool first = true;
  while (table.next(0)) {
    const rt::Nanoseconds stamp_ns = table.nanoseconds(0);
    if (first) {
      const bool fits = start.known && start.stamp_ns < stamp_ns && stamp_ns - start.stamp_ns < 5 * kPeriod;
      last_ns = fits ? start.stamp_ns : stamp_ns - kPeriod;
      add_pair(builder, last_ns, 0.0, 0.0);  // what the sums and the mean rates start from
      first = false;
    }
    travel_m += table.number(1);
    // Without a step in time there is no rate; the turn of such a row is lost, and said.
    const bool steps = stamp_ns > last_ns;
    if (!steps && table.number(2) != 0.0)
      judge.warn(table.place() + ": time does not advance; its turn is not used");
    add_pair(builder, stamp_ns, steps ? table.number(2) / rt::to_seconds(stamp_ns - last_ns) : 0.0, travel_m);
    last_ns = stamp_ns;
  }
}

}  // namespace

void import_plaza(RowJudge& judge, LogBuilder& builder) {
  const std::string front = find_set(judge.options().path, "_DR.txt", {"_GT.csv"}, "plaza");
  Start start;
  if (std::filesystem::exists(front + "_GT.csv")) {
    start = read_truth(front + "_GT.csv", judge, builder);
  } else {
    judge.warn(front + "_GT.csv: not there; the log has no truth and starts at heading 0");
  }
  read_increments(front + "_DR.txt", start, judge, builder);
}

}  // namespace sortie::toolchain
