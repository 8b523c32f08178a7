// SPDX-License-Identifier: BSD-3-Clause
// The voxel grid takes no memory from the heap: not for points, not for a full pool, not for its sorted
// order.
#include <catch2/catch.hpp>
#include <random>

#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/recorded_scans.hpp"

TEST_CASE("The voxel grid makes no heap call after construction") {
  using namespace sortie;
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  mapping::VoxelGridConfig config;
  config.full_policy = mapping::FullPolicy::evict_farthest;
  tests::OwnedGrid owned(config, 4096);
  std::mt19937 random(1);
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < 20000; ++i) {
    const auto x = static_cast<float>(random() % 40000) * 1e-3f - 20.0f;
    const auto y = static_cast<float>(random() % 40000) * 1e-3f - 20.0f;
    points.push_back({x, y, 1.0f, 0, 0});
  }
  rt::PointScan scan;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  std::vector<std::uint32_t> scratch(4096);
  std::uint64_t calls = 0;
  std::size_t sorted = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (int i = 0; i < 20; ++i) (void)owned.grid.insert(scan, {{1.0 * i, 0, 0}, {}}, 1);
    sorted = owned.grid.in_key_order(scratch).size();
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(sorted == 4096);
  CHECK(owned.grid.output().points.evicted > 0);
}
