// SPDX-License-Identifier: BSD-3-Clause
// What a ray is worth, beside the published formula in double.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/planner/ray_small.hpp"

namespace {

using namespace sortie;
using namespace sortie::tests;

// The published worth with long double's digits: the sum of entropy times c, c by two products.
long double published_worth(const planner::RayModel& model, mapping::VoxelWalk walk,
                            const std::int8_t* cells) {
  std::vector<std::uint32_t> codes;
  do codes.push_back(mapping::cell_code(cells[walk.index]));
  while (!model.ends(codes.back()) && walk.step());
  long double worth = 0;
  long double before = 1;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    // 1 - product of (1 - p) without its cancellation: 1 - xy = (1 - x) + x (1 - y).
    long double ends = 0;
    long double pass = 1;
    for (std::size_t k = i; k < codes.size(); ++k) {
      ends += pass * static_cast<long double>(model.probability(codes[k]));
      pass *= 1 - static_cast<long double>(model.probability(codes[k]));
    }
    worth += static_cast<long double>(model.entropy(codes[i])) * before * ends;
    before *= 1 - static_cast<long double>(model.probability(codes[i]));
  }
  return worth;
}

}  // namespace

TEST_CASE("A ray's worth is the published one, from p = 1e-7 to 1 - 1e-7, to a part in 1e5 and better") {
  RayMap map;
  planner::RayModelConfig config;
  config.least_visible = 0;
  config.solid = 1;
  const planner::RayModel model(config);
  std::mt19937_64 random(5);
  double worst = 0;
  for (int code = -mapping::kLogOddsLimit; code <= mapping::kLogOddsLimit; ++code) {
    std::fill(map.cells.begin(), map.cells.end(), static_cast<std::int8_t>(code));
    for (int i = 0; i < 4; ++i) {
      const double yaw = 1e-3 * static_cast<double>(random() % 6283);
      const rt::SinCos turn = rt::sincos(yaw);
      const rt::Vector3 direction{turn.cos * 0.98, turn.sin * 0.98, std::sqrt(1 - 0.98 * 0.98)};
      const mapping::VoxelWalk walk = make_walk(map.map.view(), {110.3, 160.7, 12.2}, direction, 240);
      const auto exact = static_cast<double>(published_worth(model, walk, map.cells.data()));
      const double own = model.trace(walk, map.cells.data()).fresh;
      worst = std::max(worst, std::fabs(own / exact - 1));
    }
  }
  INFO("worst relative error " << worst);
  CHECK(worst <= 1e-5);
  CHECK(worst <= 1e-12);  // double carries it
  CHECK(model.probability(mapping::cell_code(-mapping::kLogOddsLimit)) <= 1e-7);
  CHECK(1 - model.probability(mapping::cell_code(mapping::kLogOddsLimit)) <= 1e-7);
}

TEST_CASE("Entropy of every code is that of its probability") {
  const planner::RayModel model{planner::RayModelConfig{}};
  for (int code = -127; code < 128; ++code) {
    const std::uint32_t at = mapping::cell_code(static_cast<std::int8_t>(code));
    const long double odds = std::exp(static_cast<long double>(code * mapping::kLogOddsStep));
    const long double p = 1 / (1 + 1 / odds);
    const long double q = 1 / (1 + odds);
    CHECK(model.probability(at) == Approx(static_cast<double>(p)).epsilon(1e-13));
    // Without cancellation where a long double is no wider than a double.
    const long double entropy = p * std::log1p(1 / odds) + q * std::log1p(odds);
    CHECK(model.entropy(at) == Approx(static_cast<double>(entropy)).epsilon(1e-12));
  }
  CHECK(model.probability(mapping::cell_code(mapping::kUnknownCell)) == Approx(1.0 / 12).epsilon(1e-14));
}

TEST_CASE("A worth never rises as other rays are entered, not even by rounding") {
  int rises = 0;
  int falls = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SmallTask task({12, 8, 20, 5, 1}, seed);
    const planner::RayScheduler& scheduler = task.begin();
    const std::int8_t* cells = task.map.map.view().cells;
    std::vector<planner::CoverageLine> lines(400);
    std::vector<std::uint16_t> directory(1u << 12);
    std::vector<std::uint32_t> owners(lines.size());
    planner::CoverageTable table({directory, lines, owners});
    std::vector<planner::RayModel::Passed> scratch(200);
    std::vector<double> before(96);
    for (std::uint32_t j = 0; j < 96; ++j)
      before[j] = scheduler.model().trace(scheduler.walk(0, j), cells).fresh;
    for (std::uint32_t chosen = 0; chosen < 96; chosen += 9) {
      planner::RayWorth worth;
      REQUIRE(scheduler.model().cover(scheduler.walk(0, chosen), cells, table, scratch, worth));
      CHECK(worth.current == before[chosen]);
      for (std::uint32_t j = 0; j < 96; ++j) {
        const double now = scheduler.model().trace(scheduler.walk(0, j), cells, &table).current;
        CHECK(now == scheduler.model().current(scheduler.walk(0, j), cells, table).current);
        rises += now > before[j] ? 1 : 0;
        falls += now < before[j] ? 1 : 0;
        before[j] = now;
      }
    }
  }
  CHECK(rises == 0);
  CHECK(falls > 1000);
}

TEST_CASE("What is unknown ends a ray, or stands for the prior, by policy") {
  RayMap map;
  planner::RayModelConfig config;
  const mapping::VoxelWalk walk = make_walk(map.map.view(), {110.5, 160.5, 15.5}, {1, 0, 0}, 240);
  CHECK(planner::RayModel(config).trace(walk, map.cells.data()).cells > 40);
  config.unknown = planner::UnknownSpace::stop;
  CHECK(planner::RayModel(config).trace(walk, map.cells.data()).cells == 1);
}
