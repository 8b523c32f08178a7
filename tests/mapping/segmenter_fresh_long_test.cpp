// SPDX-License-Identifier: BSD-3-Clause
// Many drives, and the recorded ones as they are and with their way turned back.
#include <catch2/catch.hpp>

#include "tests/mapping/fresh_segmenter.hpp"
#include "tests/mapping/recorded_scans.hpp"

namespace {
using namespace sortie;

template <class Policy>
tests::FreshVerdict recorded_drive(const std::vector<tests::RecordedScan>& scans, double way) {
  const tests::MapSizes sizes{16384, 262136, 32768, 100000, 32768, 65536};
  mapping::RollingGridConfig grid;
  grid.radius_m = 15;
  mapping::SegmenterConfig config;
  config.min_voxels = 1;
  tests::OwnedMap<Policy> map(grid, config, sizes);
  tests::FreshVerdict verdict;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const mapping::SensorPose pose = scans[s].pose();
    (void)map.map.update(scans[s].view(), {way * pose.p_world_sensor_m, pose.q_world_sensor}, s);
    if (s % 8 == 0) tests::beside_fresh(map, Policy{}, config.radius_m, verdict, sizes);
  }
  return verdict;
}
}  // namespace

TEST_CASE("A segmenter that kept up with a hundred drives says what a fresh one says", "[heavy]") {
  for (std::uint32_t seed = 1000; seed < 1100; ++seed) {
    INFO("seed " << seed);
    CHECK(tests::wavering_drive(seed, mapping::EuclideanPolicy{}).differing == 0);
    CHECK(tests::wavering_drive(seed, mapping::SmoothnessPolicy(0.2, 0.1)).differing == 0);
  }
}

TEST_CASE("A segmenter that kept up with recorded scans says what a fresh one says", "[heavy]") {
  const auto scans = tests::read_rls(std::string(SORTIE_DATA_DIR) + "/lidar_os64/os64_thin4_000_109.rls");
  if (scans.empty()) {
    WARN("no recorded scans: skipped");
    return;
  }
  for (const double way : {1.0, -1.0}) {
    INFO("way times " << way);
    const tests::FreshVerdict near = recorded_drive<mapping::EuclideanPolicy>(scans, way);
    CHECK(near.cores > 100000);
    CHECK(near.differing == 0);
    const tests::FreshVerdict smooth = recorded_drive<mapping::SmoothnessPolicy>(scans, way);
    CHECK(smooth.cores > 100000);
    CHECK(smooth.differing == 0);
  }
}
