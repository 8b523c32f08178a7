// SPDX-License-Identifier: BSD-3-Clause
// Features of segments: finite and in range for whatever shape, right for shapes that are known, the same far
// out.
#include "mapping/segments/segment_features.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/mapping/random_worlds.hpp"

namespace {
using namespace sortie;

mapping::SegmentFeatures features_of_points(const std::vector<std::array<std::int32_t, 3>>& points) {
  mapping::SegmentMoments moments;
  for (const auto& p : points) moments.add({p[0], p[1], p[2]});
  return mapping::features_of(moments, {}, 0.1);
}

void check_features_in_range(const mapping::SegmentFeatures& f) {
  for (const double v :
       {f.linearity, f.planarity, f.scattering, f.omnivariance, f.anisotropy, f.curvature_change}) {
    REQUIRE(std::isfinite(v));
    CHECK(v >= 0.0);
    CHECK(v <= 1.0);
  }
  CHECK(f.eigenentropy >= 0.0);
  CHECK(f.eigenentropy <= std::log(3.0) + 1e-12);
  CHECK(f.spread_m2[0] >= f.spread_m2[1]);
  CHECK(f.spread_m2[1] >= f.spread_m2[2]);
  CHECK(f.spread_m2[2] >= 0.0);
}
}  // namespace

TEST_CASE("Features of one, two and three points, of lines and of planes are finite and in range") {
  const std::vector<std::vector<std::array<std::int32_t, 3>>> shapes{
      {},
      {{5, 5, 5}},
      {{5, 5, 5}, {5, 5, 5}},
      {{0, 0, 0}, {1, 2, 3}},
      {{0, 0, 0}, {400, 1, 7}, {-9, 30, 2}},
      {{0, 0, 0}, {100, 100, 100}, {200, 200, 200}, {300, 300, 300}},
      {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}, {100, 100, 0}},
      {{500000, -500000, 500000}, {500001, -500000, 500000}, {500000, -499999, 500000}},
      {{500000, -500000, 500000}}};
  for (const auto& shape : shapes) check_features_in_range(features_of_points(shape));
  const mapping::SegmentFeatures line = features_of_points(shapes[5]);
  CHECK(line.linearity == Approx(1.0));
  CHECK(line.planarity == Approx(0.0).margin(1e-9));
  const mapping::SegmentFeatures plane = features_of_points(shapes[6]);
  CHECK(plane.planarity == Approx(1.0));
  CHECK(plane.linearity == Approx(0.0).margin(1e-9));
  CHECK(plane.curvature_change == 0.0);
}

TEST_CASE("A box has the features that its edges give") {
  std::vector<std::array<std::int32_t, 3>> box;
  for (std::int32_t x = 0; x < 20; ++x) {
    for (std::int32_t y = 0; y < 10; ++y) {
      for (std::int32_t z = 0; z < 5; ++z) box.push_back({256 * x, 256 * y, 256 * z});
    }
  }
  const mapping::SegmentFeatures f = features_of_points(box);
  check_features_in_range(f);
  const auto variance = [](double n) { return (n * n - 1) / 12; };  // of n equal steps
  const double l[3] = {variance(20), variance(10), variance(5)};
  const double total = l[0] + l[1] + l[2];
  CHECK(f.voxels == 1000);
  CHECK(f.spread_m2[0] == Approx(0.01 * l[0]));
  CHECK(f.spread_m2[2] == Approx(0.01 * l[2]));
  CHECK(f.linearity == Approx((l[0] - l[1]) / l[0]));
  CHECK(f.planarity == Approx((l[1] - l[2]) / l[0]));
  CHECK(f.scattering == Approx(l[2] / l[0]));
  CHECK(f.anisotropy == Approx((l[0] - l[2]) / l[0]));
  CHECK(f.omnivariance == Approx(std::cbrt(l[0] * l[1] * l[2]) / total));
  CHECK(f.curvature_change == Approx(l[2] / total));
  double entropy = 0;
  for (const double v : l) entropy -= v / total * std::log(v / total);
  CHECK(f.eigenentropy == Approx(entropy));
  CHECK(f.centroid_m.x == Approx(0.1 * (9.5 + 0.5 / 256)));
  CHECK(f.most_m.x - f.least_m.x == Approx(1.9));
}

TEST_CASE("Sums can be added up in any order, and a map's segments are the same 10 km out") {
  tests::WorldRandom random(11);
  mapping::SegmentMoments whole;
  mapping::SegmentMoments backwards;
  std::int32_t p[300][3];
  for (auto& at : p) {
    at[0] = static_cast<std::int32_t>(random.below(100000)) - 50000;
    at[1] = static_cast<std::int32_t>(random.below(1000));
    at[2] = -static_cast<std::int32_t>(random.below(9));
    whole.add(at);
  }
  for (int i = 300; i-- > 0;) backwards.add(p[i]);
  CHECK(backwards.square[0] == whole.square[0]);
  CHECK(backwards.product[1] == whole.product[1]);
  CHECK(backwards.least[2] == whole.least[2]);
  CHECK(backwards.count == whole.count);

  mapping::RollingGridConfig config;
  mapping::SegmenterConfig segments;
  segments.min_voxels = 5;
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < 1500; ++i) {
    const float side = i % 2 == 0 ? 3.0f : -3.0f;
    points.push_back({side, random.coordinate(-2, 2), random.coordinate(-1, 1), 0, 0});
  }
  std::vector<mapping::SegmentFeatures> near;
  for (const double out : {0.0, 16384.0}) {
    tests::EuclideanMap map(config, segments, {2048, 16384, 4096, 8192, 512, 1024});
    (void)map.map.update(tests::scan_over(points), {{0.1 * 4 * out, 0, 0}, {}}, 1);
    std::vector<mapping::SegmentMoments> moments(512);
    REQUIRE(mapping::sum_segments(map.grid(), map.segmenter().graph(), map.segmenter().labelling(), moments));
    std::vector<mapping::SegmentFeatures> found;
    for (const mapping::SegmentMoments& m : moments) {
      if (m.count > 0) found.push_back(mapping::features_of(m, map.grid().centre(), config.voxel_size_m));
    }
    REQUIRE(found.size() >= 2);
    if (near.empty()) near = found;
    REQUIRE(found.size() == near.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      check_features_in_range(found[i]);
      CHECK(found[i].voxels == near[i].voxels);
      CHECK(found[i].planarity == Approx(near[i].planarity).margin(1e-6));
      CHECK(found[i].centroid_m.x - 0.4 * out == Approx(near[i].centroid_m.x).margin(1e-6));
    }
  }
}
