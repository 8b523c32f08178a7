// SPDX-License-Identifier: BSD-3-Clause
// Descriptors of segments: what a twin in long double computes from all voxels at once, the same bits
// whatever the order and the place, the same steps after a turn.
#include "mapping/recognition/segment_shape.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "tests/mapping/segment_bodies.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace {
using namespace sortie;
using mapping::SegmentDescriptor;
using testing::StepPoints;
using D = SegmentDescriptor;

/// What each step would be before it is rounded: straight from the definitions.
std::array<double, D::kSteps> twin(const StepPoints& points, double voxel_size_m) {
  const auto n = static_cast<double>(points.size());
  std::vector<Eigen::Vector3d> cells;  // from the first voxel on
  for (const auto& p : points)
    cells.emplace_back((p[0] - points[0][0]) / 256.0, (p[1] - points[0][1]) / 256.0,
                       (p[2] - points[0][2]) / 256.0);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& c : cells) mean += c / n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& c : cells) covariance += (c - mean) * (c - mean).transpose() / n;
  const testing::Eigen3 eigen = testing::eigen_of(covariance);
  const double least = std::pow(mapping::kLeastSpread_m / voxel_size_m, 2);
  double l[3], box = 1;
  std::array<double, D::kSteps> step{};
  for (unsigned i = 0; i < 3; ++i) {
    l[i] = std::max(0.0, eigen.values(2 - static_cast<int>(i)));
    step[D::kSize + i] = 8 * std::log2(1 + l[i] / least);
    box *= std::sqrt(12 * l[i] + 1);
  }
  step[D::kFill] = 240 + 8 * std::log2(n / box);
  const auto clear = [least](double a, double b) {
    return std::clamp(4 * ((a - b) / (a + least) - 0.125), 0.0, 1.0);
  };
  const double certain[2] = {clear(l[0], l[1]), std::min(clear(l[0], l[1]), clear(l[1], l[2]))};
  for (unsigned k = 0; k < 2; ++k) {
    Eigen::Vector3d axis = eigen.vectors.col(2 - static_cast<int>(k));
    if (axis.z() < 0) axis = -axis;
    double third = 0;
    for (const auto& c : cells)
      third += std::pow(std::clamp((c - mean).dot(axis) / std::sqrt(l[k] + least), -8.0, 8.0), 3) / n;
    step[D::kUpright + k] = 64 * certain[k] * axis.z();
    step[D::kThird + k] = 128 + 64 * certain[k] * (third * axis.z() + std::fabs(third) * (1 - axis.z()));
  }
  const double up = std::sqrt(covariance(2, 2) + least);
  const double out = std::sqrt(covariance(0, 0) + covariance(1, 1) + least);
  for (const auto& c : cells) {
    const Eigen::Vector3d d = c - mean;
    for (unsigned b = 0; b < D::kBins; ++b) {  // a tent about the middle of each bin
      const double height = std::clamp((d.z() / up + 2) * 7 / 4, 0.0, 7.0);
      const double radius = std::clamp(std::hypot(d.x(), d.y()) / out * 7 / 2, 0.0, 7.0);
      step[D::kHeight + b] += 128 * std::max(0.0, 1 - std::fabs(height - b)) / n;
      step[D::kRadius + b] += 128 * std::max(0.0, 1 - std::fabs(radius - b)) / n;
    }
  }
  for (double& s : step) s = std::clamp(s, 0.0, 255.0);
  return step;
}

/// Some clusters, each a box that may be flat, a line or a point.
StepPoints clusters(testing::Draws& draws) {
  StepPoints points;
  const double far = draws.uniform(0, 1) < 0.1 ? 200'000 : 5000;
  const int parts = static_cast<int>(draws.uniform(1, 5));
  for (int part = 0; part < parts; ++part) {
    double middle[3], half[3];
    for (int i = 0; i < 3; ++i) {
      middle[i] = draws.uniform(-far, far);
      half[i] = draws.uniform(0, 1) < 0.3 ? 0 : std::exp(draws.uniform(0, 9));
    }
    const int count = static_cast<int>(std::exp(draws.uniform(0, 6)));
    for (int n = 0; n < count; ++n) {
      std::array<std::int32_t, 3>& p = points.emplace_back();
      for (unsigned i = 0; i < 3; ++i)
        p[i] = static_cast<std::int32_t>(std::floor(middle[i] + draws.uniform(-half[i], half[i])));
    }
  }
  return points;
}

}  // namespace

TEST_CASE("A descriptor is what a twin that sees all voxels at once finds") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int trial = 0; trial < 300; ++trial) {
    const StepPoints points = clusters(draws);
    const double voxel_size_m = draws.uniform(0.05, 0.3);
    const SegmentDescriptor found = testing::describe(points, voxel_size_m);
    const std::array<double, D::kSteps> expected = twin(points, voxel_size_m);
    for (unsigned i = 0; i < D::kSteps; ++i) {
      // Half a step for rounding. A third moment is of places that were rounded to 1/1024: 3 E[t^2] / 2048 of
      // 64 steps, where E[t^2] <= 1. A bin is of places that were rounded to 1/256: 128 / 512 steps.
      const double rounded = i == D::kThird || i == D::kThird + 1 ? 0.1 : i >= D::kHeight ? 0.2501 : 1e-3;
      INFO("trial " << trial << ", step " << i << ", voxels " << points.size());
      CHECK(std::fabs(found.step[i] - expected[i]) <= 0.5 + rounded);
    }
  }
}

TEST_CASE("A descriptor has the same bits in any order and after any move") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  std::mt19937 order(seed);
  for (int trial = 0; trial < 100; ++trial) {
    StepPoints points = clusters(draws);
    const SegmentDescriptor found = testing::describe(points);
    const mapping::SegmentFrame frame = mapping::frame_of(testing::moments_of(points), 0.1);
    std::shuffle(points.begin(), points.end(), order);
    CHECK(testing::describe(points) == found);
    // Whole cells are whole steps; so far that the ends still lie within 2^19.
    const std::int32_t move[3] = {static_cast<std::int32_t>(draws.uniform(-300'000, 300'000)),
                                  256 * static_cast<std::int32_t>(draws.uniform(-1000, 1000)),
                                  static_cast<std::int32_t>(draws.uniform(-9, 9))};
    for (auto& p : points) {
      for (unsigned i = 0; i < 3; ++i) p[i] += move[i];
    }
    CHECK(testing::describe(points) == found);
    const mapping::SegmentFrame moved = mapping::frame_of(testing::moments_of(points), 0.1);
    for (int i = 0; i < 3; ++i) {
      CHECK(moved.middle[i] == frame.middle[i] + move[i]);
      CHECK(moved.rest[i] == frame.rest[i]);
      CHECK(std::fabs(frame.rest[i]) <= 0.5);
      CHECK(moved.axis[0][i] == frame.axis[0][i]);
      CHECK(moved.axis[1][i] == frame.axis[1][i]);
    }
    CHECK(moved.per_height == frame.per_height);
    CHECK(moved.per_radius == frame.per_radius);
  }
}

TEST_CASE("Turned about the upright, the same voxels have the same steps but for one") {
  // Either set of voxels is rounded to steps after its turn: 0.71 steps each, so they differ by 1.42. The
  // bodies have spreads of at least sqrt(0.7) of 56 m / sqrt 12, 33,000 steps, along all axes. Before they
  // are rounded, sizes differ by 0.01; upright by 64 times 2 * 1.42 / (0.125 * 33,000) of the axis and 4
  // * 1.7e-4 of how certain it is, 0.1; bins by 128 * 3.5 * 1.42 / 33,000 = 0.02; third moments, with E|t|^3
  // < 3 for a box and a smaller one beside it, by 64 * (3 * 3 * 7e-4 + 2 * 3 * 7e-4 + 3 * 7e-4) = 0.8 at the
  // very most. All of it is below 1, so that one step is the most.
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int trial = 0; trial < 40; ++trial) {
    const double half[3] = {draws.uniform(28, 60), draws.uniform(28, 60), draws.uniform(28, 60)};
    const double beside[3] = {draws.uniform(-40, 40), draws.uniform(-40, 40), draws.uniform(-40, 40)};
    std::vector<rt::Vector3> body;
    for (int i = 0; i < 1000; ++i) {
      const bool main = i < 700;
      const auto place = [&](int k) {
        return main ? draws.uniform(-half[k], half[k]) : beside[k] + draws.uniform(-8, 8);
      };
      body.push_back({place(0), place(1), place(2)});
    }
    const auto turned = [&body](double yaw) {
      StepPoints points;
      for (const rt::Vector3& p : body) {
        const double c = std::cos(yaw), s = std::sin(yaw);
        points.push_back({static_cast<std::int32_t>(std::floor(2560 * (c * p.x - s * p.y))),
                          static_cast<std::int32_t>(std::floor(2560 * (s * p.x + c * p.y))),
                          static_cast<std::int32_t>(std::floor(2560 * p.z))});
      }
      return points;
    };
    const SegmentDescriptor as_it_is = testing::describe(turned(0));
    for (int turn = 0; turn < 6; ++turn) {
      const SegmentDescriptor other = testing::describe(turned(draws.uniform(0, 2 * M_PI)));
      for (unsigned i = 0; i < D::kSteps; ++i) {
        INFO("trial " << trial << ", step " << i);
        CHECK(std::abs(as_it_is.step[i] - other.step[i]) <= 1);
      }
    }
  }
}

TEST_CASE("A mirror image and half a turn look the same but for how halves are rounded") {
  for (const testing::Body& body : testing::bodies()) {
    const StepPoints points = testing::mapped(body, 0.4, {});
    StepPoints mirrored = points, turned = points;
    for (auto& p : mirrored) p[0] = -p[0];
    for (auto& p : turned) p[0] = -p[0], p[1] = -p[1];
    INFO(body.name);
    CHECK(difference(testing::describe(mirrored), testing::describe(points)) <= 2);
    CHECK(difference(testing::describe(turned), testing::describe(points)) <= 2);
  }
}

TEST_CASE("What has no extent or no first axis has a descriptor all the same") {
  CHECK(testing::describe({}) == SegmentDescriptor{});
  const SegmentDescriptor one = testing::describe({{7, -5, 9}});
  CHECK(one == SegmentDescriptor{{0, 0, 0, 0, 0, 128, 128, 240, 0, 0, 0, 64, 64, 0, 0, 0, 128}});
  SegmentDescriptor many = testing::describe(StepPoints(64, {400'000, -400'000, 1}));
  CHECK(many.step[D::kFill] == 255);
  many.step[D::kFill] = one.step[D::kFill];
  CHECK(many == one);

  const auto cells = [](int x, int y, int z) {
    StepPoints points;
    for (int i = 0; i < x * y * z; ++i)
      points.push_back({256 * (i % x), 256 * (i / x % y), 256 * (i / x / y)});
    return testing::describe(points);
  };
  for (const SegmentDescriptor& cube : {cells(10, 10, 10), cells(2, 2, 2)}) {
    CHECK(cube.step[D::kUpright] == 0);
    CHECK(cube.step[D::kUpright + 1] == 0);
    CHECK(cube.step[D::kThird] == 128);
    CHECK(cube.step[D::kFill] == 240);
  }
  const SegmentDescriptor line = cells(100, 1, 1), pole = cells(1, 1, 100), floor = cells(40, 40, 1),
                          wall = cells(1, 80, 25);
  CHECK(line.step[D::kSize] == 104);  // 8 log2(1 + 0.01 (10^4 - 1) / 12 * 1024)
  CHECK(line.step[D::kSize + 1] == 0);
  CHECK(line.step[D::kFill] == 240);
  CHECK(line.step[D::kUpright] == 0);
  CHECK(pole.step[D::kUpright] == 64);
  CHECK(pole.step[D::kUpright + 1] == 0);
  CHECK(pole.step[D::kRadius] == 128);
  CHECK(floor.step[D::kUpright] == 0);
  CHECK(floor.step[D::kFill] == 240);
  CHECK(wall.step[D::kUpright] == 0);
  CHECK(wall.step[D::kUpright + 1] == 64);
  for (const SegmentDescriptor& even : {line, pole, floor, wall}) {
    CHECK(even.step[D::kThird] == 128);
    CHECK(even.step[D::kThird + 1] == 128);
  }
}

TEST_CASE("Up is not down") {
  StepPoints pole;
  for (int z = 0; z < 60; ++z) {
    for (int k = 0; k < (z < 40 ? 1 : 5); ++k) pole.push_back({51 * k, 0, 256 * z});
  }
  StepPoints fallen = pole;
  for (auto& p : fallen) p[2] = -p[2];
  const SegmentDescriptor heavy_top = testing::describe(pole), heavy_foot = testing::describe(fallen);
  CHECK(heavy_top.step[D::kThird] < 100);  // the long tail points down
  CHECK(std::abs(heavy_top.step[D::kThird] + heavy_foot.step[D::kThird] - 256) <= 1);
  // Lying, both are the same thing.
  for (auto* body : {&pole, &fallen}) {
    for (auto& p : *body) std::swap(p[0], p[2]);
  }
  CHECK(testing::describe(pole).step[D::kThird] > 156);
  CHECK(difference(testing::describe(pole), testing::describe(fallen)) <= 2);
}

TEST_CASE("Bodies that are mapped anew, turned and moved, look like themselves and not like others",
          "[heavy]") {
  // No random numbers: what holds of these 120 views holds always. A wall along the grid has up to 1.41 times
  // fewer voxels than one across, 4 steps of fill; edges and a top in one layer of cells or in two add to
  // that.
  const std::vector<testing::Body> bodies = testing::bodies();
  std::vector<SegmentDescriptor> first;
  for (const testing::Body& body : bodies)
    first.push_back(testing::describe(testing::mapped(body, 0, {0.03, 0.02, 0.01})));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      INFO(bodies[i].name << " and " << bodies[k].name);
      CHECK(difference(first[i], first[k]) > 60);
    }
  }
  for (int view = 0; view < 120; ++view) {
    const rt::Vector3 move{0.1 * (view % 7) / 7, 0.1 * (view % 5) / 5, 0.1 * (view % 3) / 3};
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const SegmentDescriptor seen =
          testing::describe(testing::mapped(bodies[i], 3.0 * view * M_PI / 180, move));
      INFO(bodies[i].name << ", view " << view);
      CHECK(mapping::same_sizes(seen, first[i], 8));
      CHECK(std::abs(seen.step[D::kFill] - first[i].step[D::kFill]) <= 6);
      const std::uint32_t own = difference(seen, first[i]);
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        if (k != i) CHECK(difference(seen, first[k]) > own + 20);
      }
    }
  }
}

TEST_CASE("The difference of two descriptors is the sum over all their steps") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int trial = 0; trial < 1000; ++trial) {
    SegmentDescriptor a, b;
    int sum = 0, most = 0;
    for (unsigned i = 0; i < D::kSteps; ++i) {
      const bool ends = trial % 10 == 0;
      a.step[i] = static_cast<std::uint8_t>(ends ? 255 * (draws.uniform(0, 1) < 0.5) : draws.uniform(0, 256));
      b.step[i] = static_cast<std::uint8_t>(ends ? 255 - a.step[i] : draws.uniform(0, 256));
      sum += (i < 2 ? 8 : 1) * (std::max(a.step[i], b.step[i]) - std::min(a.step[i], b.step[i]));
      if (i < 3) most = std::max(most, std::abs(int{a.step[i]} - int{b.step[i]}));
    }
    CHECK(difference(a, b) == static_cast<std::uint32_t>(sum));
    CHECK(difference(b, a) == static_cast<std::uint32_t>(sum));
    CHECK(mapping::same_sizes(a, b, most));
    CHECK_FALSE(mapping::same_sizes(a, b, most - 1));
  }
}
