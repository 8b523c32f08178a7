// SPDX-License-Identifier: BSD-3-Clause
// Layers of surfels against a std::map.
#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

#include "tests/mapping/registration_rig.hpp"

namespace {
using namespace sortie;

/// z, y, x: the order in which new cells get their room.
using CellAt = std::array<std::int32_t, 3>;
struct ByHeight {
  bool operator()(const CellAt& a, const CellAt& b) const {
    return std::tie(a[2], a[1], a[0]) < std::tie(b[2], b[1], b[0]);
  }
};

struct SurfelLayerTwin {
  struct Cell {
    std::vector<rt::Vector3> points;  ///< from the cell's low corner, in cells
    std::size_t known{};              ///< of them, in the Gaussian
  };
  std::map<CellAt, Cell, ByHeight> cells;
  mapping::SurfelLayerCounts counts;
  std::size_t most{}, min_points{};
  CellAt width{};
  CellAt middle{};
  bool has_middle{};

  bool inside(const CellAt& cell) const {
    for (std::size_t i = 0; i < 3 && has_middle; ++i) {
      if (cell[i] < middle[i] - width[i] / 2 || cell[i] >= middle[i] + width[i] / 2) return false;
    }
    return true;
  }
  void evict_beyond(const CellAt& about) {
    middle = about;
    has_middle = true;
    for (auto it = cells.begin(); it != cells.end();) {
      const bool stays = inside(it->first);
      if (!stays) ++counts.evicted;
      it = stays ? std::next(it) : cells.erase(it);
    }
  }
  /// The one that has the place of another in the window.
  auto in_place_of(const CellAt& cell) {
    return std::find_if(cells.begin(), cells.end(), [&](const auto& one) {
      for (std::size_t i = 0; i < 3; ++i) {
        if ((one.first[i] - cell[i]) % width[i] != 0) return false;
      }
      return true;
    });
  }
  void insert(const std::vector<std::pair<CellAt, rt::Vector3>>& points) {
    std::set<CellAt, ByHeight> missing;
    for (const auto& p : points) {
      if (cells.count(p.first) == 0) missing.insert(p.first);
    }
    for (const bool near : {true, false}) {
      for (const CellAt& cell : missing) {
        if (inside(cell) != near) continue;
        const auto old = in_place_of(cell);
        if (old != cells.end()) {
          if (!near) continue;
          cells.erase(old);
          ++counts.evicted;
        }
        if (cells.size() == most) continue;
        cells[cell];
        ++counts.created;
      }
    }
    for (const auto& p : points) {
      ++counts.in;
      const auto found = cells.find(p.first);
      if (found == cells.end()) {
        ++counts.pool_full;
      } else {
        ++counts.used;
        found->second.points.push_back(p.second);
      }
    }
    for (auto& [at, cell] : cells) {
      if (cell.points.size() >= min_points && cell.points.size() > cell.known + cell.known / 10)
        cell.known = cell.points.size();
    }
  }
};

bool same_counts(const mapping::SurfelLayerCounts& a, const mapping::SurfelLayerCounts& b) {
  return a.in == b.in && a.used == b.used && a.outside == b.outside && a.pool_full == b.pool_full &&
         a.created == b.created && a.evicted == b.evicted;
}

/// A drive with random scans; the sensor takes leaps now and then. `pool`: surfels.
void drive_layer(std::uint64_t seed, std::size_t pool, bool evicts, std::int32_t start) {
  INFO("seed " << seed << ", pool " << pool << ", evicts " << evicts << ", start " << start);
  testing::Draws draws(seed);
  const double cell_m = 0.4;
  testing::OwnedSurfelLayer owned(cell_m, 3, 2, pool, 3);
  testing::OwnedSurfelLayer shuffled(cell_m, 3, 2, pool, 3);
  SurfelLayerTwin twin;
  twin.most = pool;
  twin.min_points = 3;
  twin.width = {8, 8, 4};
  CellAt at{start, -start, start / 2};
  const auto whole = [&](double low, double high) {
    return static_cast<std::int32_t>(std::floor(draws.uniform(low, high)));
  };
  for (std::uint32_t scan = 1; scan <= 60; ++scan) {
    for (std::int32_t& part : at) part += draws.uniform(0, 1) < 0.1 ? whole(-20, 21) : whole(-1, 2);
    std::vector<std::pair<CellAt, rt::Vector3>> points;
    std::vector<rt::Vector3> points_m;
    for (int i = 0; i < 150; ++i) {
      const CellAt cell{at[0] + whole(-6, 6), at[1] + whole(-6, 6), at[2] + whole(-3, 3)};
      const rt::Vector3 in{draws.uniform(0.01, 0.99), draws.uniform(0.01, 0.99), draws.uniform(0.01, 0.99)};
      points.push_back({cell, in});
      points_m.push_back({cell_m * (cell[0] + in.x), cell_m * (cell[1] + in.y), cell_m * (cell[2] + in.z)});
    }
    if (evicts) {
      const rt::Vector3 sensor{cell_m * (at[0] + 0.5), cell_m * (at[1] + 0.5), cell_m * (at[2] + 0.5)};
      owned.layer.evict_beyond(sensor);
      shuffled.layer.evict_beyond(sensor);
      twin.evict_beyond(at);
    }
    owned.insert(points_m, scan);
    testing::shuffle(points_m, draws);
    shuffled.insert(points_m, scan);
    twin.insert(points);
    INFO("scan " << scan);
    REQUIRE(same_counts(owned.layer.counts(), twin.counts));
    REQUIRE(owned.layer.counts().in ==
            owned.layer.counts().used + owned.layer.counts().outside + owned.layer.counts().pool_full);
    REQUIRE(owned.layer.size() == twin.cells.size());
    std::size_t wrong = 0;
    for (const auto& [cell, held] : twin.cells) {
      const mapping::SurfelCell key{{cell[0], cell[1], cell[2]}};
      const mapping::SurfelIndex index = owned.layer.find(key);
      REQUIRE(index != mapping::kNoSurfel);
      const mapping::Surfel* const surfel = owned.layer.surfel_at(key);
      REQUIRE((surfel != nullptr) == (held.known > 0));
      if (surfel == nullptr) continue;
      rt::Vector3 mean;
      for (std::size_t i = 0; i < held.known; ++i) mean = mean + (1.0 / double(held.known)) * held.points[i];
      const double off[3] = {mean.x - 0.5, mean.y - 0.5, mean.z - 0.5};
      wrong += surfel->count != held.known;
      for (int i = 0; i < 3; ++i)
        wrong += std::fabs(cell_m * off[i] - static_cast<double>(surfel->mean_m[i])) > cell_m / 4096 + 1e-6;
    }
    REQUIRE(wrong == 0);
    REQUIRE(owned.keys == shuffled.keys);
    REQUIRE(owned.window == shuffled.window);
    REQUIRE(std::memcmp(owned.surfels.data(), shuffled.surfels.data(), pool * sizeof(mapping::Surfel)) == 0);
  }
  CHECK(twin.counts.evicted > 0);
  CHECK((pool >= 256 || twin.counts.pool_full > 0));
}
}  // namespace

TEST_CASE("A layer of surfels holds what a map of cells holds, over many windows and with a full pool") {
  const auto seed = std::random_device{}();
  for (std::uint32_t i = 0; i < 3; ++i) {
    for (const std::size_t pool : {std::size_t{256}, std::size_t{60}, std::size_t{1}}) {
      drive_layer(seed + i, pool, true, 0);
      drive_layer(seed + i, pool, false, 0);
    }
    drive_layer(seed + i, 256, true, 1'000'000);
    drive_layer(seed + i, 60, false, -1'000'000);
  }
}

TEST_CASE("Points that no whole coordinates reach are counted, and nothing else comes of them") {
  testing::OwnedSurfelLayer owned(0.4, 3, 2, 64, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const double far = 0.4 * (1 << 20);
  std::vector<rt::Vector3> points;
  for (const double bad : {nan, inf, -inf, far, -far, 1e7, -1e300, 1e300}) {
    points.push_back({bad, 0, 0});
    points.push_back({0, bad, 0});
    points.push_back({0, 0, bad});
  }
  owned.insert(points, 1);
  CHECK(owned.layer.counts().in == points.size());
  CHECK(owned.layer.counts().outside == points.size());
  CHECK(owned.layer.size() == 0);
  // What they just reach is held, at either end.
  const double near = far - 1.3;
  owned.insert({{near, near, near}, {-near, -near, -near}, {-1e-18, -1e-18, 0}, {0.4 - 1e-16, 0, 0}}, 2);
  CHECK(owned.layer.counts().used == 4);
  for (const double at : {near, -near}) {
    mapping::SurfelPlace place;
    REQUIRE(owned.layer.place(at, at, at, place));
    for (int i = 0; i < 3; ++i) {
      CHECK(place.cell.at[i] == static_cast<std::int32_t>(std::floor(at / 0.4)));
      CHECK(mapping::SurfelCell::from_key(place.cell.key()).at[i] == place.cell.at[i]);
    }
    CHECK(owned.layer.surfel_at(place.cell) != nullptr);
  }
  owned.layer.evict_beyond({nan, 0, 0});
  owned.layer.evict_beyond({0, 1e300, 0});
  CHECK(owned.layer.counts().evicted == 0);
}

TEST_CASE("A far return does not take the place of a near surface") {
  // Two walls that are one window apart: the sensor sees both, again and again.
  testing::OwnedSurfelLayer owned(0.4, 5, 4, 4096);
  std::vector<rt::Vector3> near, all;
  testing::Draws draws(3);
  for (int i = 0; i < 400; ++i) {
    near.push_back({draws.uniform(-4.79, -4.41), draws.uniform(-2, 2), draws.uniform(-1, 1)});
    all.push_back(near.back());
    all.push_back(near.back() + rt::Vector3{12.8, 0, 0});
  }
  testing::OwnedSurfelLayer alone(0.4, 5, 4, 4096);
  for (std::uint32_t scan = 1; scan <= 5; ++scan) {
    owned.layer.evict_beyond({0.2, 0.2, 0.2});
    owned.insert(all, scan);
    alone.layer.evict_beyond({0.2, 0.2, 0.2});
    alone.insert(near, scan);
  }
  std::uint32_t known = 0;
  for (const rt::Vector3& p : near) {
    mapping::SurfelPlace place;
    REQUIRE(owned.layer.place(p.x, p.y, p.z, place));
    const mapping::Surfel* const surfel = owned.layer.surfel_at(place.cell);
    const mapping::Surfel* const wanted = alone.layer.surfel_at(place.cell);
    REQUIRE((surfel != nullptr) == (wanted != nullptr));
    if (surfel == nullptr) continue;
    CHECK(surfel->count == wanted->count);
    ++known;
  }
  CHECK(known > 300);
  CHECK(owned.layer.counts().pool_full == 5 * near.size());
}

TEST_CASE("A layer that was cleared learns anew, whatever number the next scan has") {
  testing::OwnedSurfelLayer owned(0.4, 3, 2, 64);
  const std::vector<rt::Vector3> points{{0.1, 0.1, 0.1}, {0.2, 0.1, 0.1}, {0.1, 0.2, 0.1},
                                        {0.2, 0.2, 0.1}, {0.1, 0.1, 0.2}, {0.3, 0.1, 0.1}};
  const mapping::SurfelCell cell{{0, 0, 0}};
  for (const std::uint32_t scan : {0u, 0u, 7u, 7u}) {
    owned.layer.clear();
    CHECK(owned.layer.size() == 0);
    CHECK(owned.layer.surfel_at(cell) == nullptr);
    owned.insert(points, scan);
    REQUIRE(owned.layer.surfel_at(cell) != nullptr);
    CHECK(owned.layer.surfel_at(cell)->count == points.size());
  }
}

TEST_CASE("A cell fades when it has what it remembers, and never overflows") {
  testing::OwnedSurfelLayer owned(0.4, 3, 2, 64, 5, 32768);
  std::vector<rt::Vector3> points;
  for (int i = 0; i < 9000; ++i) points.push_back({0.39 * (i % 90) / 90, 0.39 * (i / 90) / 100, 0.2});
  std::uint32_t held = 0;
  for (std::uint32_t scan = 1; scan <= 12; ++scan) {
    owned.insert(points, scan);
    held = std::min(held + 9000, 32768u);
    if (held == 32768) held /= 2;
    const mapping::SurfelIndex index = owned.layer.find({{0, 0, 0}});
    CHECK(owned.sums[index].count == held);
    CHECK(std::fabs(static_cast<double>(owned.layer.surfel(index).variance_m2[0])) < 1e-9);
    CHECK(std::fabs(static_cast<double>(owned.layer.surfel(index).mean_m[2])) < 1e-4);
  }
}
