// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/scan_sets.hpp"

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

std::vector<MapAndScans> hall_set(int halls, int scans, const StartError& error, std::uint64_t seed) {
  testing::Draws draws(seed);
  std::vector<MapAndScans> sets;
  for (int h = 0; h < halls; ++h) {
    const Hall hall(draws);
    MapAndScans& set = sets.emplace_back();
    for (int i = 0; i < kScansOfMap; ++i) set.map.push_back(hall.scan(draws));
    for (int i = 0; i < scans; ++i) {
      set.scans.push_back(hall.scan(draws));
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

std::unique_ptr<OwnedRegistration> map_of(const MapAndScans& set, const mapping::RegistrationConfig& config) {
  auto owned = std::make_unique<OwnedRegistration>(config);
  for (const PlacedScan& scan : set.map) {
    (void)owned->registration.take(scan.points);
    owned->registration.insert(scan.pose);
  }
  return owned;
}

}  // namespace sortie::bench
