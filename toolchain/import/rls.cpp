// SPDX-License-Identifier: BSD-3-Clause
// Recorded lidar scans with poses. File: 'RLS1', u32 scans, f32 unit in m; per scan: f64 t in s, f64[12]
// T_world_lidar (3x4, row-major), u32 n, u32 source index, i16[n][3] coordinates / unit, u16[n] intensity.
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>

#include "rt/rotation.hpp"
#include "toolchain/import/binary_file.hpp"
#include "toolchain/import/data_set.hpp"
#include "toolchain/import/kinds.hpp"

namespace sortie::toolchain {
namespace {

using Pose = std::array<double, 12>;

constexpr std::uint64_t kBytesPerPoint = 8;

/// Empty if the pose is a rigid motion, else what is wrong with it.
std::string fault_of(double t_s, const Pose& pose) {
  if (!std::isfinite(t_s) || std::fabs(t_s) > 4.5e9)
    return "its time is not finite or more than 4.5e9 s from 0";
  for (const double x : pose) {
    if (!std::isfinite(x) || std::fabs(x) > 1e12) return "its pose is not finite";
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double dot = 0.0;
      for (std::size_t k = 0; k < 3; ++k) dot += pose[4 * i + k] * pose[4 * j + k];
      if (std::fabs(dot - (i == j ? 1.0 : 0.0)) > 1e-3)
        return "its pose is no rotation (rows are not orthonormal)";
    }
  }
  const double det = pose[0] * (pose[5] * pose[10] - pose[6] * pose[9]) -
                     pose[1] * (pose[4] * pose[10] - pose[6] * pose[8]) +
                     pose[2] * (pose[4] * pose[9] - pose[5] * pose[8]);
  return det > 0.0 ? "" : "its pose is a reflection";
}

/// The lidar's pose as truth, where the scan shall not have it.
rt::TruthSample truth_of(const rt::ScanHeader& header) {
  rt::TruthSample truth;
  truth.stamp_ns = header.stamp_ns;
  std::copy(std::begin(header.p_world_sensor_m), std::end(header.p_world_sensor_m), truth.p_world_body_m);
  std::copy(std::begin(header.q_world_sensor), std::end(header.q_world_sensor), truth.q_world_body);
  truth.flags = rt::kTruthPosition | rt::kTruthHeight | rt::kTruthOrientation;
  return truth;
}

rt::ScanHeader header_of(double t_s, const Pose& pose) {
  rt::ScanHeader header;
  header.stamp_ns = static_cast<rt::Nanoseconds>(std::floor(t_s * 1e9 + 0.5));
  header.flags = rt::kScanPosed;
  rt::RotationMatrix r;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) r.m[3 * i + j] = pose[4 * i + j];
    header.p_world_sensor_m[i] = pose[4 * i + 3];
  }
  rt::store(rt::normalised(rt::from_matrix(r)), header.q_world_sensor);
  return header;
}

std::vector<rt::ScanPoint> read_points(BinaryFile& file, std::uint32_t n, float unit_m) {
  std::vector<rt::ScanPoint> points(n);
  std::array<std::int16_t, 3> xyz{};
  for (rt::ScanPoint& point : points) {
    file.get(xyz);  // room was checked for all of them
    point.x_m = static_cast<float>(xyz[0]) * unit_m;
    point.y_m = static_cast<float>(xyz[1]) * unit_m;
    point.z_m = static_cast<float>(xyz[2]) * unit_m;
  }
  for (rt::ScanPoint& point : points) file.get(point.intensity);
  return points;
}

void read_scans(const std::string& path, bool& first, RowJudge& judge, LogBuilder& builder) {
  BinaryFile file(path, "RLS1", "a file of recorded lidar scans (.rls)");
  judge.begin(path);
  std::uint32_t count = 0;
  float unit_m = 0.0f;
  if (!file.get(count) || !file.get(unit_m) || !(unit_m > 0.0f && unit_m < 10.0f)) {
    throw firmware::InputError(
        path + ": byte 4: the head is damaged (number of scans, unit in m); copy the file again");
  }
  rt::Nanoseconds latest_ns = 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint64_t offset = file.position();
    const std::string place = path + ": scan " + std::to_string(k) + " at byte " + std::to_string(offset);
    double t_s = 0.0;
    Pose pose{};
    std::uint32_t n = 0;
    std::uint32_t source = 0;
    const bool whole = file.get(t_s) && file.get(pose) && file.get(n) && file.get(source) &&
                       file.left() / kBytesPerPoint >= n;
    if (!whole) {
      judge.cut_off(offset, std::to_string(k) + " of " + std::to_string(count) + " scans are whole");
      break;
    }
    std::vector<rt::ScanPoint> points = read_points(file, n, unit_m);
    if (const std::string fault = fault_of(t_s, pose); !fault.empty()) {
      judge.bad(place, fault);
      continue;
    }
    judge.good();
    rt::ScanHeader header = header_of(t_s, pose);
    if (k > 0 && header.stamp_ns < latest_ns) judge.time_backwards(place, latest_ns - header.stamp_ns);
    latest_ns = header.stamp_ns;
    if (first) builder.set_initial_pose(header.p_world_sensor_m, header.q_world_sensor);
    first = false;
    if (judge.options().no_poses) {
      builder.add(header.stamp_ns, truth_of(header));
      rt::ScanHeader bare;
      bare.stamp_ns = header.stamp_ns;
      header = bare;
    }
    builder.add(header.stamp_ns, header, std::move(points));
  }
  judge.finish(true);
}

}  // namespace

void import_rls(RowJudge& judge, LogBuilder& builder) {
  const std::vector<std::string> files = find_files(judge.options().path, ".rls");
  if (files.empty())
    throw firmware::InputError(judge.options().path + ": holds no *.rls; give a folder of them or one file");
  bool first = true;
  for (const std::string& file : files) read_scans(file, first, judge, builder);
}

}  // namespace sortie::toolchain
