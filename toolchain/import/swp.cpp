// SPDX-License-Identifier: BSD-3-Clause
// Sweeps with a time for each point. File: 'SWP1', u32 rows, u32 columns; per point, row by row in the
// sensor's order: f32 x, y, z in m (NaN: no return), u32 t in ns since the first.
#include <algorithm>
#include <filesystem>

#include "rt/stamp_gate.hpp"
#include "toolchain/import/binary_file.hpp"
#include "toolchain/import/data_set.hpp"
#include "toolchain/import/kinds.hpp"
#include "toolchain/import/number_table.hpp"
#include "toolchain/import/odometry_steps.hpp"
#include "toolchain/import/sweep_times.hpp"
#include "toolchain/import/text_file.hpp"

namespace sortie::toolchain {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSweepPointBytes = sizeof(SweepPoint);

struct SweepFile {
  std::string path;
  rt::Nanoseconds start_ns{};  ///< time of its first point
};

/// Sweeps by time. A file's name is the time of its first point in seconds; a single sweep may have any name
/// and begins at 0 then.
std::vector<SweepFile> find_sweeps(const std::string& path) {
  const std::vector<std::string> found = find_files(path, ".swp");
  if (found.empty()) throw firmware::InputError(path + ": holds no *.swp; give a folder of them or one file");
  std::vector<SweepFile> sweeps;
  for (const std::string& file : found) {
    SweepFile sweep{file, 0};
    const bool named = parse_seconds(fs::path(file).stem().string(), sweep.start_ns);
    if (!named && found.size() > 1)
      throw firmware::InputError(file +
                                     ": one of several sweeps, and its name is no time in seconds; name it " +
                                     "after the time of its first point (12.5.swp), or give this file alone",
                                 2);
    if (!named) sweep.start_ns = 0;
    if (sweep.start_ns < 0 || sweep.start_ns > kLatestStamp_ns)
      throw firmware::InputError(file + ": the time in its name is not within 0 to 9e9 s; rename it", 2);
    sweeps.push_back(sweep);
  }
  std::stable_sort(sweeps.begin(), sweeps.end(),
                   [](const SweepFile& a, const SweepFile& b) { return a.start_ns < b.start_ns; });
  return sweeps;
}

/// Why the sweep is not used; empty if it is.
std::string use_sweep(const SweepFile& sweep, std::vector<SweepPoint> points, std::uint32_t rows,
                      std::uint32_t columns, RowJudge& judge, LogBuilder& builder) {
  if (points.empty()) return "not one row of its points is whole";
  TimedScan scan = order_sweep(points, rows, columns);
  if (!scan.fault.empty()) return scan.fault;
  const ReturnCounts& returns = scan.returns;
  const std::uint64_t wrong = returns.time_negative + returns.time_unsorted + returns.time_beyond;
  const std::uint64_t timed = returns.in - returns.no_return - returns.not_finite;
  if (static_cast<double>(wrong) > judge.options().max_bad_rows * static_cast<double>(timed))
    return std::to_string(wrong) + " of its " + std::to_string(timed) + " points have times that cannot be";
  judge.returns(returns);
  if (wrong > 0)
    judge.warn(sweep.path + ": " + std::to_string(wrong) + " points with times that cannot be were left out");
  rt::ScanHeader header;
  header.stamp_ns = sweep.start_ns + scan.newest_ns;
  builder.add(header.stamp_ns, header, std::move(scan.points));
  return {};
}

void read_sweep(const SweepFile& sweep, RowJudge& judge, LogBuilder& builder) {
  BinaryFile file(sweep.path, "SWP1", "a lidar sweep with times (.swp)");
  std::uint32_t rows = 0;
  std::uint32_t columns = 0;
  if (!file.get(rows) || !file.get(columns) || rows == 0 || columns == 0)
    throw firmware::InputError(sweep.path +
                               ": byte 4: the head is damaged (rows, columns); copy the file again");
  const std::uint64_t points_there = file.left() / kSweepPointBytes;
  // The rows of the sensor that are whole can be used.
  const auto whole = static_cast<std::uint32_t>(std::min<std::uint64_t>(rows, points_there / columns));
  const std::uint64_t bytes = kSweepPointBytes * whole * columns;
  if (whole < rows) {
    judge.cut_off(file.position() + bytes, fs::path(sweep.path).filename().string() + ": " +
                                               std::to_string(whole) + " of " + std::to_string(rows) +
                                               " rows of points are whole");
  } else if (file.left() > bytes) {
    judge.warn(sweep.path + ": " + std::to_string(file.left() - bytes) +
               " bytes behind the last point were not used");
  }
  std::vector<SweepPoint> points(std::size_t{whole} * columns);
  for (SweepPoint& point : points) file.get(point);  // room was checked for all of them
  const std::string fault = use_sweep(sweep, std::move(points), whole, columns, judge, builder);
  if (fault.empty()) {
    judge.good();
  } else {
    judge.bad(sweep.path, fault);
  }
}

void read_summed_poses(const std::string& path, RowJudge& judge, LogBuilder& builder) {
  NumberTable table(
      path, {"the odometry of a swp set", {"t_s"}, {"x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"}}, judge);
  OdometrySteps odometry(builder);
  rt::Nanoseconds receipt_ns = -kLatestStamp_ns;
  while (table.next(0)) {
    const rt::Nanoseconds stamp_ns = table.nanoseconds(0);
    if (rt::is_far(stamp_ns))
      throw firmware::InputError(table.place() + ": 't_s' lies more than 73 years from 0; give s, not ns");
    receipt_ns = std::max(receipt_ns, stamp_ns);
    const rt::Quaternion q{table.number(7), table.number(4), table.number(5), table.number(6)};
    odometry.add(receipt_ns, stamp_ns, {table.number(1), table.number(2), table.number(3)},
                 rt::normalised(q));
  }
}

}  // namespace

void import_swp(RowJudge& judge, LogBuilder& builder) {
  const std::string& path = judge.options().path;
  const std::vector<SweepFile> sweeps = find_sweeps(path);
  const fs::path folder = fs::is_directory(path) ? fs::path(path) : fs::path(path).parent_path();
  const std::string odometry = (folder / "odom.csv").string();
  // Before the sweeps: of one time, a pose comes first.
  if (fs::exists(odometry)) {
    read_summed_poses(odometry, judge, builder);
  } else {
    judge.warn(odometry + ": not there; the log holds no motion, and no scene can place its sweeps");
  }
  judge.begin(path);  // all of them as one: a bad sweep is a bad row
  for (const SweepFile& sweep : sweeps) read_sweep(sweep, judge, builder);
  judge.finish(true);
}

}  // namespace sortie::toolchain
