// SPDX-License-Identifier: BSD-3-Clause
// The choice of returns: spread over surfaces, the same for any order of a scan.
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <set>

#include "tests/mapping/registration_rig.hpp"

namespace {
using namespace sortie;

struct SampleRig {
  std::vector<mapping::ScanSample::Slot> slots;
  std::vector<mapping::SamplePoint> out;
  mapping::ScanSampleCounts counts;
  mapping::ScanSample chooser;

  SampleRig(double edge_m, double near_m, double far_m, std::size_t most)
      : slots(std::bit_ceil(8 * most)), out(most), chooser(edge_m, near_m, far_m, slots) {}
  std::vector<mapping::SamplePoint> choose(const std::vector<rt::ScanPoint>& scan) {
    const std::size_t kept = chooser.choose(scan, out, counts);
    return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(kept)};
  }
};

std::array<std::uint32_t, 3> bits_of(float x, float y, float z) {
  return {std::bit_cast<std::uint32_t>(x), std::bit_cast<std::uint32_t>(y), std::bit_cast<std::uint32_t>(z)};
}

bool same_bits(const std::vector<mapping::SamplePoint>& a, const std::vector<mapping::SamplePoint>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}
}  // namespace

TEST_CASE("A sample has at most one return a cube, counts the others, and does not depend on their order") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (int run = 0; run < 12; ++run) {
    const double edge_m = draws.uniform(0.05, 1.0);
    const double near_m = draws.uniform(0.1, 2.0), far_m = draws.uniform(8, 60);
    const std::size_t most = run % 3 == 0 ? 200 : 4000;
    const testing::RegistrationWorld world = testing::random_hall(draws);
    testing::TestLidar lidar;
    std::vector<rt::ScanPoint> scan = lidar.scan(world, {0, 0, 1.2}, {}, draws);
    // Returns that are none, some of them twice, and one exactly at either end.
    for (int i = 0; i < 50; ++i) {
      const auto v = static_cast<float>(draws.uniform(-1, 1));
      const rt::ScanPoint bad[] = {{nan, v, v, 0, 0},   {v, nan, v, 0, 0}, {v, v, inf, 0, 0},
                                   {-inf, v, v, 0, 0},  {0, 0, 0, 0, 0},   {v * 1e-3f, 0, 0, 0, 0},
                                   {3e38f, v, v, 0, 0}, {v, v, -900, 0, 0}};
      scan.insert(scan.end(), std::begin(bad), std::end(bad));
      scan.push_back(scan[static_cast<std::size_t>(i)]);
    }
    // The twin: what belongs to which count, and which cubes there are.
    mapping::ScanSampleCounts wanted;
    std::map<std::array<int, 3>, int> cubes;
    std::set<std::array<std::uint32_t, 3>> returns;
    for (const rt::ScanPoint& p : scan) {
      const double x = p.x_m, y = p.y_m, z = p.z_m;
      const double range = std::sqrt(x * x + y * y + z * z);
      ++wanted.in;
      returns.insert(bits_of(p.x_m, p.y_m, p.z_m));
      if (std::isnan(range) || std::isinf(range)) {
        ++wanted.not_finite;
      } else if (range < near_m) {
        ++wanted.too_near;
      } else if (range > far_m) {
        ++wanted.too_far;
      } else {
        ++cubes[{static_cast<int>(std::floor(x / edge_m)), static_cast<int>(std::floor(y / edge_m)),
                 static_cast<int>(std::floor(z / edge_m))}];
      }
    }
    SampleRig rig(edge_m, near_m, far_m, most);
    const std::vector<mapping::SamplePoint> first = rig.choose(scan);
    CHECK(rig.counts.in == wanted.in);
    CHECK(rig.counts.not_finite == wanted.not_finite);
    CHECK(rig.counts.too_near == wanted.too_near);
    CHECK(rig.counts.too_far == wanted.too_far);
    CHECK(rig.counts.kept == first.size());
    CHECK(rig.counts.in == rig.counts.kept + rig.counts.not_finite + rig.counts.too_near +
                               rig.counts.too_far + rig.counts.thinned);
    std::map<std::array<int, 3>, int> chosen;
    for (const mapping::SamplePoint& p : first) {
      const std::array<int, 3> cube{static_cast<int>(std::floor(static_cast<double>(p.x_m) / edge_m)),
                                    static_cast<int>(std::floor(static_cast<double>(p.y_m) / edge_m)),
                                    static_cast<int>(std::floor(static_cast<double>(p.z_m) / edge_m))};
      CHECK(cubes.count(cube) == 1);
      CHECK(++chosen[cube] == 1);
      CHECK(returns.count(bits_of(p.x_m, p.y_m, p.z_m)) == 1);
    }
    // Few cubes share a slot of a table eight times as large: hardly any is lost that there was room for.
    const std::size_t room = std::min(most, cubes.size());
    CHECK(first.size() <= room);
    CHECK(static_cast<double>(first.size()) > 0.9 * static_cast<double>(room));
    for (int again = 0; again < 4; ++again) {
      testing::shuffle(scan, draws);
      SampleRig other(edge_m, near_m, far_m, most);
      CHECK(same_bits(first, other.choose(scan)));
      CHECK(same_bits(first, rig.choose(scan)));  // nothing is left of the scan before
    }
  }
}

TEST_CASE("A sample of nothing, of returns that are none, and of one return many times") {
  SampleRig rig(0.1, 0.5, 60, 64);
  CHECK(rig.choose({}).empty());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(rig.choose(std::vector<rt::ScanPoint>(1000, {nan, nan, nan, 0, 0})).empty());
  CHECK(rig.counts.not_finite == 1000);
  CHECK(rig.choose(std::vector<rt::ScanPoint>(1000, {1, 2, 3, 0, 0})).size() == 1);
  CHECK(rig.counts.thinned == 999);
  // The limits belong to what is kept.
  CHECK(rig.choose({{0.5f, 0, 0, 0, 0}, {60, 0, 0, 0, 0}, {0, -0.5f, 0, 0, 0}}).size() == 3);
  CHECK(rig.choose({{0.4999f, 0, 0, 0, 0}, {60.01f, 0, 0, 0, 0}}).empty());
}
