// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/scan_sets.hpp"

#include <cstring>
#include <fstream>

#include "tests/mapping/recorded_scans.hpp"

namespace sortie::bench {
namespace {
constexpr int kScansOfMap = 6;
constexpr std::size_t kRecordedOfMap = 5;

PlacedScan placed(const tests::RecordedScan& scan) {
  const mapping::SensorPose pose = scan.pose();
  return {scan.points, {pose.p_world_sensor_m, pose.q_world_sensor}};
}
}  // namespace

std::vector<MapAndScans> hall_set(int halls, int scans, const StartError& error, std::uint64_t seed,
                                  const testing::TestLidar& lidar) {
  testing::Draws draws(seed);
  std::vector<MapAndScans> sets;
  for (int h = 0; h < halls; ++h) {
    const Hall hall(draws);
    MapAndScans& set = sets.emplace_back();
    for (int i = 0; i < kScansOfMap; ++i) set.map.push_back(hall.scan(draws));
    for (int i = 0; i < scans; ++i) {
      set.scans.push_back(hall.scan(draws, lidar));
      set.starts.push_back(start_beside(set.scans.back().pose, error, draws));
    }
  }
  return sets;
}

std::vector<MapAndScans> recorded_set(const std::string& data, const StartError& error, std::uint64_t seed) {
  const std::vector<tests::RecordedScan> scans = tests::read_rls(data + "/lidar_os64/os64_thin4_000_109.rls");
  testing::Draws draws(seed);
  std::vector<MapAndScans> sets;
  for (std::size_t i = 2 * kRecordedOfMap; i < scans.size(); i += kRecordedOfMap) {
    MapAndScans& set = sets.emplace_back();
    for (std::size_t k = i - kRecordedOfMap; k < i; ++k) set.map.push_back(placed(scans[k]));
    set.scans.push_back(placed(scans[i]));
    set.starts.push_back(start_beside(set.scans.back().pose, error, draws));
  }
  return sets;
}

std::vector<MapAndScans> sweep_set(const std::string& data, const Field& field, int starts,
                                   const StartError& error, std::uint64_t seed) {
  std::ifstream file(data + "/tradr_robot/tradr_os0_128.swp", std::ios::binary);
  const auto take = [&file](auto& value) { file.read(reinterpret_cast<char*>(&value), sizeof value); };
  char magic[4]{};
  std::uint32_t rows = 0;
  std::uint32_t columns = 0;
  take(magic);
  take(rows);
  take(columns);
  if (!file || std::memcmp(magic, "SWP1", 4) != 0 || rows > 4096 || columns > 65'536) return {};
  MapAndScans set;
  PlacedScan map, scan;
  for (std::uint32_t i = 0; i < rows * columns; ++i) {
    float p[3]{};
    std::uint32_t t_ns = 0;
    take(p);
    take(t_ns);
    if (!file) return {};
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) continue;
    const rt::ScanPoint point{p[0], p[1], p[2], 0, 0};
    if (i % columns % 2 == 0) {
      map.points.push_back(point);
      continue;
    }
    const double x = static_cast<double>(p[0]), y = static_cast<double>(p[1]), z = static_cast<double>(p[2]);
    const bool seen = std::fabs(std::atan2(y, x)) <= 0.5 * field.turn_rad &&
                      std::fabs(std::atan2(z, std::hypot(x, y))) <= 0.5 * field.up_rad;
    if (seen && i / columns % static_cast<std::uint32_t>(field.each_row) == 0) scan.points.push_back(point);
  }
  testing::Draws draws(seed);
  set.map.push_back(std::move(map));
  for (int i = 0; i < starts; ++i) {
    set.scans.push_back(scan);
    set.starts.push_back(start_beside(scan.pose, error, draws));
  }
  return {set};
}

std::unique_ptr<OwnedRegistration> map_of(const MapAndScans& set, const mapping::RegistrationConfig& config) {
  auto owned = std::make_unique<OwnedRegistration>(config);
  for (const PlacedScan& scan : set.map) {
    (void)owned->registration.take(scan.points);
    owned->registration.insert(scan.pose);
  }
  return owned;
}

}  // namespace sortie::bench
