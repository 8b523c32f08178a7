// SPDX-License-Identifier: BSD-3-Clause
// The occupancy map beside a twin that keeps every cell of the world in double, and the walk along a ray.
#include "mapping/occupancy/occupancy.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "mapping/occupancy/voxel_walk.hpp"
#include "rt/math.hpp"

namespace {

using namespace sortie;
using namespace sortie::mapping;

struct WalkedCell {
  std::int32_t c[3];
};

WalkedCell cell_of(const OccupancyView& view, std::uint32_t index) {
  const auto i = static_cast<std::int32_t>(index);
  return {{i % view.size[0], i / view.size[0] % view.size[1], i / view.size[0] / view.size[1]}};
}

rt::Vector3 random_direction(std::mt19937_64& random) {
  for (;;) {
    const auto part = [&random] { return 1e-6 * static_cast<double>(random() % 2'000'001) - 1.0; };
    const double x = part();
    const double y = part();
    const double z = part();
    const double n = std::sqrt(x * x + y * y + z * z);
    if (n > 0.01 && n <= 1) return {x / n, y / n, z / n};
  }
}

OccupancyConfig small_occupancy() {
  OccupancyConfig config;
  config.size[0] = 48;
  config.size[1] = 40;
  config.size[2] = 24;
  config.roll_cells = 4;
  config.anchor[0] = 0.5;
  config.max_range_m = 20;
  return config;
}

}  // namespace

TEST_CASE("A walk goes from face to face, stays in the window and misses no cell of the line") {
  OccupancyView view;
  view.size[0] = 60;
  view.size[1] = 50;
  view.size[2] = 40;
  view.voxel_size_m = 1;
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto start = [&random](std::int32_t n) {
      return 1e-4 * static_cast<double>(random() % (10000u * static_cast<unsigned>(n)));
    };
    const double x = start(60);
    const double y = start(50);
    const double z = start(40);
    rt::Vector3 direction = random_direction(random);
    if (trial % 5 == 0) direction = trial % 10 == 0 ? rt::Vector3{0, -1, 0} : rt::Vector3{0.6, 0.8, 0};
    const double length = 1 + static_cast<double>(random() % 60);
    VoxelWalk walk = make_walk(view, {x, y, z}, direction, length);
    std::set<std::uint32_t> seen{walk.index};
    WalkedCell before = cell_of(view, walk.index);
    REQUIRE(before.c[0] == static_cast<std::int32_t>(x));
    while (walk.step()) {
      REQUIRE(walk.index < view.cell_count());
      const WalkedCell now = cell_of(view, walk.index);
      REQUIRE(std::abs(now.c[0] - before.c[0]) + std::abs(now.c[1] - before.c[1]) +
                  std::abs(now.c[2] - before.c[2]) ==
              1);
      REQUIRE(seen.insert(walk.index).second);
      before = now;
    }
    // Points of the line that are not within a thousandth of a face lie in cells that were walked.
    for (double t = 0; t < length - 0.01; t += 0.037) {
      const double p[3] = {x + t * direction.x, y + t * direction.y, z + t * direction.z};
      bool clear = true;
      std::uint32_t index = 0;
      std::uint32_t stride = 1;
      for (int a = 0; a < 3; ++a) {
        const double cell = std::floor(p[a]);
        clear = clear && p[a] - cell > 1e-3 && p[a] - cell < 1 - 1e-3 && cell >= 0 && cell < view.size[a];
        if (clear) index += stride * static_cast<std::uint32_t>(cell);
        stride *= static_cast<std::uint32_t>(view.size[a]);
      }
      if (clear) REQUIRE(seen.count(index) == 1);
    }
  }
}

TEST_CASE("A walk does not pass a slanted wall, which Bresenham's line does") {
  // A wall of one cell along x + y = 40: cells touch at edges only.
  const auto wall = [](std::int32_t x, std::int32_t y) { return x + y == 40 || x + y == 41; };
  OccupancyView view;
  view.size[0] = 41;
  view.size[1] = 41;
  view.size[2] = 3;
  view.voxel_size_m = 1;
  int leaks = 0;
  for (int i = 0; i < 200; ++i) {
    const rt::Vector3 from{3.5 + 0.05 * i, 5.5, 1.5};
    const double s = std::sqrt(0.5);
    VoxelWalk walk = make_walk(view, from, {s, s, 0}, 45);
    bool stopped = false;
    do {
      const WalkedCell at = cell_of(view, walk.index);
      // Thin: the cells of one diagonal alone.
      stopped = stopped || (wall(at.c[0], at.c[1]) && at.c[0] + at.c[1] == 40);
    } while (walk.step());
    CHECK(stopped);
    // Bresenham from cell to cell on the exact diagonal: both coordinates change at once.
    std::int32_t x = static_cast<std::int32_t>(from.x);
    std::int32_t y = 5;
    bool hit = false;
    for (; x < 41 && y < 41; ++x, ++y) hit = hit || x + y == 40;
    leaks += hit ? 0 : 1;
  }
  CHECK(leaks > 50);
}

TEST_CASE("The map agrees with a twin in double over random rays, saturation and rolling", "[heavy]") {
  OccupancyConfig config = small_occupancy();
  config.max_range_m = 4.5;  // some rays are longer: they end in nothing
  std::vector<std::int8_t> cells(static_cast<std::size_t>(OccupancyMap::memory_bytes(config)));
  OccupancyMap map(config, cells);
  REQUIRE(map.usable());
  const double limit = kLogOddsLimit * kLogOddsStep;
  const double prior = rt::log(config.prior / (1 - config.prior));
  struct Odds {
    double exact;  // never rounded
    int steps;     // rounded at each update, as the map says it does
  };
  const auto steps_of = [](double odds) { return static_cast<int>(std::lround(odds / kLogOddsStep)); };
  std::map<std::tuple<int, int, int>, Odds> twin;  // by the world's cell
  std::mt19937_64 random(3);
  for (int ray = 0; ray < 4000; ++ray) {
    const rt::Vector3 from{0.002 * ray, 0.1 - 0.0015 * ray, 0.05 + 0.0008 * (ray < 2000 ? ray : 4000 - ray)};
    REQUIRE(map.centre_on(from) == Status::ok);
    const OccupancyView view = map.view();
    for (auto it = twin.begin(); it != twin.end();) {  // what rolled out is forgotten
      const auto [x, y, z] = it->first;
      const bool inside = x >= view.low[0] && x < view.low[0] + view.size[0] && y >= view.low[1] &&
                          y < view.low[1] + view.size[1] && z >= view.low[2] &&
                          z < view.low[2] + view.size[2];
      it = inside ? std::next(it) : twin.erase(it);
    }
    const double length = 1 + 1e-3 * static_cast<double>(random() % 4000);
    const rt::Vector3 to = from + length * random_direction(random);
    std::vector<std::tuple<int, int, int>> passed;
    const bool hits = length <= config.max_range_m;
    VoxelWalk walk = make_walk(view, view.to_window(from), (1 / length) * (to - from),
                               std::min(length, config.max_range_m) / config.voxel_size_m);
    const std::tuple<int, int, int> last{static_cast<int>(std::floor(to.x / 0.2)),
                                         static_cast<int>(std::floor(to.y / 0.2)),
                                         static_cast<int>(std::floor(to.z / 0.2))};
    do {
      const WalkedCell at = cell_of(view, walk.index);
      passed.push_back({at.c[0] + view.low[0], at.c[1] + view.low[1], at.c[2] + view.low[2]});
    } while (!(hits && passed.back() == last) && walk.step());
    REQUIRE(map.update_ray(from, to, true) == Status::ok);
    const auto add = [&](const std::tuple<int, int, int>& at, double odds) {
      Odds& cell = twin.emplace(at, Odds{prior, steps_of(prior)}).first->second;
      cell.exact = std::min(limit, std::max(-limit, cell.exact + odds));
      cell.steps = std::min(kLogOddsLimit, std::max(-kLogOddsLimit, cell.steps + steps_of(odds)));
    };
    const bool reached = hits && passed.back() == last;
    for (std::size_t i = 0; i + (reached ? 1 : 0) < passed.size(); ++i)
      add(passed[i], rt::log(config.miss / (1 - config.miss)));
    const OccupancyView now = map.view();
    const auto [lx, ly, lz] = last;
    if (hits && lx >= now.low[0] && lx < now.low[0] + now.size[0] && ly >= now.low[1] &&
        ly < now.low[1] + now.size[1] && lz >= now.low[2] && lz < now.low[2] + now.size[2])
      add(last, rt::log(config.hit / (1 - config.hit)));
  }
  const OccupancyView view = map.view();
  CHECK(map.output().rolls > 3);
  CHECK(map.output().known == twin.size());
  std::size_t wrong_side = 0;
  for (const auto& [at, odds] : twin) {
    const auto [x, y, z] = at;
    const std::size_t index = static_cast<std::size_t>(
        ((z - view.low[2]) * view.size[1] + y - view.low[1]) * view.size[0] + x - view.low[0]);
    REQUIRE(int{cells[index]} == odds.steps);
    wrong_side += (odds.exact > 0.5 && cells[index] < 0) || (odds.exact < -0.5 && cells[index] > 0) ? 1 : 0;
  }
  INFO(wrong_side << " of " << twin.size() << " on the wrong side");
  CHECK(wrong_side <= twin.size() / 200);
}

TEST_CASE("The map refuses what it cannot use, and counts it") {
  OccupancyConfig config = small_occupancy();
  std::vector<std::int8_t> cells(static_cast<std::size_t>(OccupancyMap::memory_bytes(config)));
  OccupancyMap map(config, cells);
  CHECK(map.update_ray({0, 0, 0}, {std::nan(""), 0, 0}, true) == Status::not_finite);
  CHECK(map.update_ray({1e308, 0, 0}, {-1e308, 0, 0}, true) == Status::not_finite);
  CHECK(map.update_ray({1000, 0, 0}, {1001, 0, 0}, true) == Status::out_of_range);
  CHECK(map.update_ray({0, 0, 0}, {0.1, 0, 0}, true) == Status::out_of_range);
  CHECK(map.centre_on({1e300, 0, 0}) == Status::out_of_range);
  CHECK(map.centre_on({std::nan(""), 0, 0}) == Status::not_finite);
  CHECK(map.output().known == 0);
  CHECK(map.output().rays == 4);
  // A return beyond the range frees the way and marks nothing.
  CHECK(map.update_ray({0, 0, 0}, {100, 0, 0}, true) == Status::ok);
  CHECK(map.output().hits == 0);
  CHECK(map.output().misses > 0);
  // Far away nothing is left.
  CHECK(map.centre_on({1e6, 0, 0}) == Status::ok);
  CHECK(map.output().known == 0);
  config.prior = 0;
  CHECK_FALSE(OccupancyMap(config, cells).usable());
  CHECK(OccupancyMap(config, cells).update_ray({0, 0, 0}, {1, 0, 0}, true) == Status::out_of_range);
  CHECK_FALSE(OccupancyMap(small_occupancy(), std::span<std::int8_t>(cells).first(5)).usable());
}

TEST_CASE("The map's state goes to bytes and back") {
  const OccupancyConfig config = small_occupancy();
  std::vector<std::int8_t> cells(static_cast<std::size_t>(OccupancyMap::memory_bytes(config)));
  std::vector<std::int8_t> others(cells.size());
  OccupancyMap map(config, cells);
  OccupancyMap other(config, others);
  std::mt19937_64 random(8);
  for (int i = 0; i < 100; ++i) (void)map.update_ray({0, 0, 0}, 4.0 * random_direction(random), i % 2 == 0);
  rt::Archive measure = rt::Archive::measuring();
  map.archive(measure);
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  map.archive(write);
  rt::Archive read = rt::Archive::reading(bytes);
  other.archive(read);
  CHECK(read.status() == Status::ok);
  CHECK(cells == others);
  CHECK(other.output().known == map.output().known);
  // A window that no map can have is refused, and nothing overflows.
  const std::int32_t low[3] = {map.output().low_x, map.output().low_y, map.output().low_z};
  std::uint8_t pattern[sizeof low];
  std::memcpy(pattern, low, sizeof low);
  const auto found = std::search(bytes.begin(), bytes.end(), std::begin(pattern), std::end(pattern));
  REQUIRE(found != bytes.end());
  const std::int32_t far = std::numeric_limits<std::int32_t>::min();
  std::memcpy(&*found, &far, sizeof far);
  rt::Archive broken = rt::Archive::reading(bytes);
  other.archive(broken);
  CHECK(broken.status() == Status::malformed);
  CHECK(other.centre_on({1e6, 1e6, 1e6}) == Status::ok);
}

TEST_CASE("Every cell that a ray changes moves the chain of changes") {
  const OccupancyConfig config = small_occupancy();
  std::vector<std::int8_t> cells(static_cast<std::size_t>(OccupancyMap::memory_bytes(config)));
  std::vector<std::int8_t> others(cells.size());
  OccupancyMap map(config, cells);
  OccupancyMap other(config, others);
  std::mt19937_64 random(9);
  for (int i = 0; i < 200; ++i) {
    const rt::Vector3 to = 4.0 * random_direction(random);
    const bool hit = i % 2 == 0;
    REQUIRE(map.update_ray({0, 0, 0}, to, hit) == other.update_ray({0, 0, 0}, to, hit));
    REQUIRE(map.output().changes == other.output().changes);
  }
  // The same counts, another cell: the last return is one cell off, and so is all that follows.
  (void)map.update_ray({0.1, 0.1, 0.1}, {2.1, 0.1, 0.1}, true);
  (void)other.update_ray({0.1, 0.1, 0.1}, {0.1, 2.1, 0.1}, true);
  CHECK(map.output().misses == other.output().misses);
  CHECK(map.output().changes != other.output().changes);
  (void)map.update_ray({0, 0, 0}, {1, 0, 0}, true);
  (void)other.update_ray({0, 0, 0}, {1, 0, 0}, true);
  CHECK(map.output().changes != other.output().changes);
}

TEST_CASE("A scan may be entered sparsely") {
  const OccupancyConfig config = small_occupancy();
  std::mt19937_64 random(10);
  std::vector<rt::ScanPoint> points(101);
  for (rt::ScanPoint& point : points) {
    const rt::Vector3 v = 4.0 * random_direction(random);
    point.x_m = static_cast<float>(v.x);
    point.y_m = static_cast<float>(v.y);
    point.z_m = static_cast<float>(v.z);
  }
  rt::PointScan scan;
  scan.points = points.data();
  scan.header.points = 101;
  for (const std::uint32_t stride : {1u, 3u, 100u, 101u, 0xffffffffu}) {
    std::vector<std::int8_t> cells(static_cast<std::size_t>(OccupancyMap::memory_bytes(config)));
    std::vector<std::int8_t> others(cells.size());
    OccupancyMap map(config, cells);
    OccupancyMap other(config, others);
    REQUIRE(map.update(scan, {}, stride) == Status::ok);
    for (std::size_t i = 0; i < points.size(); i += stride)
      (void)other.update_ray({},
                             {static_cast<double>(points[i].x_m), static_cast<double>(points[i].y_m),
                              static_cast<double>(points[i].z_m)},
                             true);
    CHECK(cells == others);
    CHECK(map.output().changes == other.output().changes);
    CHECK(map.update(scan, {{std::nan(""), 0, 0}, {}}, stride) == Status::not_finite);
    CHECK(map.output().rays == 2 * other.output().rays);
    CHECK(map.update(scan, {}, 0) == Status::out_of_range);
  }
}
