// SPDX-License-Identifier: BSD-3-Clause
// Reader for the recorded lidar scans (.rls) that the map's tests replay. Small and strict; for tests only.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "mapping/grid/sensor_pose.hpp"
#include "rt/samples.hpp"

namespace sortie::tests {

/// One scan in the runtime's form, with the matrix that the file gives.
struct RecordedScan {
  double t_s{};
  rt::RotationMatrix r_world_lidar;
  rt::Vector3 p_world_lidar;
  std::vector<rt::ScanPoint> points;

  rt::PointScan view() const {
    rt::PointScan scan;
    scan.header.stamp_ns = static_cast<rt::Nanoseconds>(t_s * 1e9);
    scan.header.points = static_cast<std::uint32_t>(points.size());
    scan.points = points.data();
    return scan;
  }
  mapping::SensorPose pose() const { return {p_world_lidar, from_matrix(r_world_lidar)}; }
};

/// All scans of a file; empty when it is not there or does not have the declared form.
inline std::vector<RecordedScan> read_rls(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const auto take = [&file](auto& value) { file.read(reinterpret_cast<char*>(&value), sizeof value); };
  char magic[4]{};
  std::uint32_t scans = 0;
  float unit_m = 0;
  take(magic);
  take(scans);
  take(unit_m);
  std::vector<RecordedScan> result;
  if (!file || std::memcmp(magic, "RLS1", 4) != 0) return result;
  for (std::uint32_t s = 0; s < scans; ++s) {
    RecordedScan scan;
    double t[12]{};
    std::uint32_t n = 0;
    std::uint32_t source = 0;
    take(scan.t_s);
    take(t);
    take(n);
    take(source);
    if (!file) return {};
    scan.r_world_lidar = {{t[0], t[1], t[2], t[4], t[5], t[6], t[8], t[9], t[10]}};
    scan.p_world_lidar = {t[3], t[7], t[11]};
    std::vector<std::int16_t> xyz(3 * n);
    std::vector<std::uint16_t> intensity(n);
    file.read(reinterpret_cast<char*>(xyz.data()), static_cast<std::streamsize>(6 * n));
    file.read(reinterpret_cast<char*>(intensity.data()), static_cast<std::streamsize>(2 * n));
    if (!file) return {};
    scan.points.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      scan.points[i] = {static_cast<float>(xyz[3 * i]) * unit_m, static_cast<float>(xyz[3 * i + 1]) * unit_m,
                        static_cast<float>(xyz[3 * i + 2]) * unit_m, intensity[i], 0};
    }
    result.push_back(std::move(scan));
  }
  return result;
}

}  // namespace sortie::tests
