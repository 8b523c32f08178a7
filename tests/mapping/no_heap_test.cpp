// SPDX-License-Identifier: BSD-3-Clause
// The local map takes no memory from the heap: not for points, not for a full pool, not for segments.
#include <catch2/catch.hpp>
#include <random>

#include "rt/posix/heap_trap.hpp"
#include "rt/samples.hpp"
#include "tests/mapping/owned_map.hpp"

TEST_CASE("A local map with normals makes no heap call after construction, also when its pools are full") {
  using namespace sortie;
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  tests::MapSizes sizes;
  sizes.points = 20'000;
  tests::SmoothMap owned({}, {}, sizes);
  std::mt19937 random(1);
  std::vector<rt::ScanPoint> points;
  for (std::uint32_t i = 0; i < sizes.points; ++i) {
    const auto x = static_cast<float>(random() % 40000) * 1e-3f - 20.0f;
    const auto y = static_cast<float>(random() % 40000) * 1e-3f - 20.0f;
    points.push_back({x, y, 1.0f, 0, 0});
  }
  rt::PointScan scan;
  scan.header.points = sizes.points;
  scan.points = points.data();
  std::uint64_t calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (unsigned i = 0; i < 20; ++i) (void)owned.map.update(scan, {{1.0 * i, 0, 0}, {}}, i);
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(owned.grid().output().points.evicted > 0);
  CHECK(owned.grid().output().points.pool_full + owned.grid().output().points.forced > 0);
}
