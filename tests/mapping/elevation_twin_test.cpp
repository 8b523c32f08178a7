// SPDX-License-Identifier: BSD-3-Clause
// The elevation map beside a twin in double that keeps every return and asks every ray at every cell.
#include <catch2/catch.hpp>

#include "tests/mapping/elevation_twin.hpp"
#include "tests/mapping/world_random.hpp"

namespace {

using namespace sortie;
using namespace sortie::mapping;

ElevationConfig small_elevation() {
  ElevationConfig config;
  config.size = 64;
  return config;
}

// Blocks of half a metre, each as high as chance wants it, one in four with a roof over it.
struct Blocks {
  explicit Blocks(std::uint32_t of) : seed(of) {}
  double height_m(double x, double y) const { return 0.01 * static_cast<double>(mix(x, y) % 60); }
  bool roofed(double x, double y) const { return (mix(x, y) >> 20) % 4 == 0; }
  std::uint32_t mix(double x, double y) const {
    const auto a = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(2 * x)));
    const auto b = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(2 * y)));
    std::uint32_t h = (a * 0x9e3779b1u) ^ (b * 0x85ebca77u) ^ (seed * 0xc2b2ae3du);
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    return h ^ (h >> 12);
  }
  std::uint32_t seed;
};

rt::Quaternion random_turn(tests::WorldRandom& random) {
  return rt::exp_rotation({random.between(-0.6, 0.6), random.between(-0.6, 0.6), random.between(-3, 3)});
}

// Returns from blocks and roofs around a sensor, in its frame.
std::vector<rt::ScanPoint> random_returns(tests::WorldRandom& random, const Blocks& blocks,
                                          const SensorPose& pose, std::uint32_t count) {
  std::vector<rt::ScanPoint> points;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double x = pose.p_world_sensor_m.x + random.between(-2.2, 2.2);
    const double y = pose.p_world_sensor_m.y + random.between(-2.2, 2.2);
    double z = blocks.height_m(x, y) + 0.01 * random.normal();
    if (blocks.roofed(x, y) && random.below(2) == 0) z = 2.2 + 0.01 * random.normal();
    const rt::Vector3 p = rt::rotate_back(pose.q_world_sensor, rt::Vector3{x, y, z} - pose.p_world_sensor_m);
    points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0, 0});
  }
  return points;
}

struct TwinVerdict {
  std::size_t cells{};
  std::size_t shaky{};
  std::size_t bounded{};
};

// Every cell of the window: surfaces within a millimetre, bounds within the rounding of heights.
TwinVerdict judge_elevation(const ElevationMap& map, const tests::ElevationTwin& twin) {
  TwinVerdict verdict;
  const ElevationView view = map.view();
  std::uint64_t known = 0;
  for (std::int64_t y = view.low[1]; y < view.low[1] + view.size; ++y) {
    for (std::int64_t x = view.low[0]; x < view.low[0] + view.size; ++x) {
      const auto found = twin.cells().find({x, y});
      const ElevationCell& cell = view.cells[view.index(x, y)];
      const std::int32_t bound = view.bounds[view.index(x, y)];
      known += cell.surfaces() > 0 ? 1 : 0;
      if (found == twin.cells().end()) {
        REQUIRE(cell.surfaces() == 0);
        REQUIRE(bound == ElevationView::kNoBound);
        continue;
      }
      INFO("cell " << x << " " << y);
      if (bound == ElevationView::kNoBound) {
        REQUIRE(std::isinf(found->second.bound_m));
      } else {
        ++verdict.bounded;
        const double bound_m = static_cast<double>(view.level_m) + bound / kHeightUnits;
        REQUIRE(bound_m >= found->second.least_m - 1e-4);
        REQUIRE(bound_m <= found->second.bound_m + 4e-6);
      }
      REQUIRE((cell.surfaces() == 0) == found->second.seen.empty());
      if (found->second.seen.empty()) continue;
      ++verdict.cells;
      bool shaky = false;
      const auto surfaces = twin.surfaces(found->second, shaky);
      if (shaky) {
        ++verdict.shaky;
        continue;
      }
      REQUIRE(cell.surfaces() == surfaces.size());
      for (std::uint32_t i = 0; i < surfaces.size(); ++i) {
        const double height_m = static_cast<double>(view.level_m) + cell.height[i] / kHeightUnits;
        REQUIRE(std::fabs(height_m - surfaces[i].height_m) < 1e-3);
        REQUIRE(cell.flags[i] == surfaces[i].flags);
        const std::uint16_t weight = aged_weight(cell.weight[i], cell.variance, view.variance);
        const double twins = kUnitWeightVariance_m2 / surfaces[i].variance_m2;
        // Each return rounds by a half, each ageing by one and by less than a part of variance.
        const double most =
            (1.5 + twins * twins / kVarianceParts) * static_cast<double>(found->second.seen.size() + 1);
        REQUIRE(std::fabs(weight - twins) <= most);
      }
    }
  }
  REQUIRE(map.output().known == known);
  return verdict;
}

}  // namespace

TEST_CASE("elevation: a window that rolls with every job holds what the twin of all returns holds",
          "[heavy]") {
  TwinVerdict all;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    tests::WorldRandom random(seed);
    const Blocks blocks(seed);
    tests::OwnedElevation owned(small_elevation());
    REQUIRE(owned.map.usable());
    tests::ElevationTwin twin(small_elevation());
    rt::Vector3 p{random.between(-50, 50), random.between(-50, 50), 0.0};
    for (int job = 0; job < 25; ++job) {
      p.x += random.between(-0.12, 0.25);
      p.y += random.between(-0.2, 0.2);
      p.z = random.between(0.75, 1.3);
      const double moved_m2 = 1e-6 * random.between(0, 200);
      REQUIRE(owned.map.centre_on({p.x, p.y, 0.5}) == Status::ok);
      REQUIRE(owned.map.add_variance(moved_m2) == Status::ok);
      twin.keep(owned.map.view());
      twin.move(moved_m2);
      const SensorPose pose{p, random_turn(random)};
      const auto points = random_returns(random, blocks, pose, 900);
      REQUIRE(owned.map.update(tests::scan_of(points, job), pose) == Status::ok);
      twin.take(tests::scan_of(points, job), pose);
    }
    const TwinVerdict verdict = judge_elevation(owned.map, twin);
    all.cells += verdict.cells;
    all.shaky += verdict.shaky;
    all.bounded += verdict.bounded;
    CHECK(owned.map.output().rolls > 15);
  }
  CAPTURE(all.cells, all.shaky, all.bounded);
  // Most cells are judged, not passed over.
  CHECK(all.cells > 30'000);
  CHECK(all.bounded > 30'000);
  CHECK(3 * all.shaky < all.cells);
}
