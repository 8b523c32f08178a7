// SPDX-License-Identifier: BSD-3-Clause
// Returns that hang between an edge and what lies behind it, and what takes back what stood in a cell.
#include "mapping/elevation/veil.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "tests/mapping/elevation_looker.hpp"

using namespace sortie;

namespace {

rt::ScanPoint ray_end(double azimuth, double tilt, double range) {
  return {static_cast<float>(range * std::cos(tilt) * std::cos(azimuth)),
          static_cast<float>(range * std::cos(tilt) * std::sin(azimuth)),
          static_cast<float>(range * std::sin(tilt)), 0, 0};
}

constexpr double kHalfDegree = 0.5 * 3.14159265358979 / 180.0;
const double kThreeDegrees = std::tan(6 * kHalfDegree);

std::vector<rt::ScanPoint> kept_of(const std::vector<rt::ScanPoint>& points, double slope = kThreeDegrees) {
  std::vector<rt::ScanPoint> kept(points.size());
  kept.resize(mapping::without_veils(points, slope, kept));
  return kept;
}

}  // namespace

TEST_CASE("veil: of an edge in front of a wall what hangs between goes, both surfaces stay") {
  for (const bool turned : {false, true}) {
    std::vector<rt::ScanPoint> line;
    for (int i = 0; i < 20; ++i)
      line.push_back(ray_end(kHalfDegree * i, 0, i < 9 ? 2.0 : i < 11 ? 3.0 + i - 9 : 6.0));
    if (turned) std::reverse(line.begin(), line.end());
    const auto kept = kept_of(line);
    CHECK(kept.size() == 18);
    for (const rt::ScanPoint& point : kept) {
      const double range = std::hypot(static_cast<double>(point.x_m), static_cast<double>(point.y_m));
      CHECK((std::abs(range - 2.0) < 1e-3 || std::abs(range - 6.0) < 1e-3));
    }
  }
}

TEST_CASE("veil: posts, floors and rough ground lose nothing") {
  std::vector<rt::ScanPoint> line;
  for (int i = 0; i < 20; ++i) line.push_back(ray_end(kHalfDegree * i, 0, i == 7 || i == 12 ? 2.0 : 6.0));
  CHECK(kept_of(line).size() == line.size());
  line.clear();
  for (int i = 0; i < 60; ++i) {  // a floor 0.5 m below, out to 8 m
    const double tilt = -0.9 + kHalfDegree * i * 1.65;
    if (tilt < -0.0626) line.push_back(ray_end(0.2, tilt, 0.5 / std::sin(-tilt)));
  }
  REQUIRE(line.size() > 40);
  CHECK(kept_of(line).size() == line.size());
  CHECK(kept_of(line, 0.0).size() == line.size());
  std::mt19937_64 random(77);
  line.clear();
  for (int i = 0; i < 400; ++i)
    line.push_back(ray_end(kHalfDegree * i, -0.3, 3.0 + 0.02 * static_cast<double>(random() % 100) / 100.0));
  CHECK(kept_of(line).size() == line.size());
}

TEST_CASE("veil: bad points, few points and little room") {
  CHECK(kept_of({}).empty());
  CHECK(kept_of({ray_end(0, 0, 1)}).size() == 1);
  std::vector<rt::ScanPoint> line{
      ray_end(0, 0, 1), {NAN, 0, 0, 0, 0}, ray_end(kHalfDegree, 0, 3), {}, ray_end(0, 0, 1)};
  CHECK(kept_of(line).size() == line.size());
  std::vector<rt::ScanPoint> little(2);
  CHECK(mapping::without_veils(line, kThreeDegrees, little) == 2);
}

TEST_CASE("elevation: who has gone away is taken back by rays, what still stands is not") {
  tests::Looker looker(tests::window_64());
  const rt::Vector3 from{-1.0, 0.025, 0.6};
  const auto floor = tests::patch(0.8, 1.4, -0.1, 0.1, 0.0);
  const auto post = tests::patch(0.5, 0.55, 0.0, 0.05, 0.3);
  looker.look(from, tests::patch(0.4, 0.8, -0.1, 0.1, 0.0));
  for (int i = 0; i < 30; ++i) looker.look(from, post);
  const auto evidence = [&looker] {
    const mapping::ElevationView view = looker.owned.map.view();
    return view.evidence[view.index(view.cell_of(0.525), view.cell_of(0.025))];
  };
  CHECK(evidence().hits > 10);
  CHECK(!evidence().is_free());
  // Still there: rays pass beside it, and some meet it.
  for (int i = 0; i < 40; ++i) {
    looker.look(from, floor);
    looker.look(from, post);
  }
  CHECK(!evidence().is_free());
  int looks = 0;
  for (; looks < 200 && !evidence().is_free(); ++looks) looker.look(from, floor);
  CAPTURE(looks);
  CHECK(evidence().is_free());
  // It comes back.
  for (int i = 0; i < 6; ++i) looker.look(from, post);
  CHECK(!evidence().is_free());
}
