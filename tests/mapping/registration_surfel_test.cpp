// SPDX-License-Identifier: BSD-3-Clause
// Gaussians of cells against a batch over their points in long double.
#include "mapping/registration/surfel.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cstring>

#include "tests/mapping/registration_rig.hpp"

namespace {
using namespace sortie;
using Vector3l = Eigen::Matrix<long double, 3, 1>;
using Matrix3l = Eigen::Matrix<long double, 3, 3>;

struct SurfelBatch {
  Vector3l mean = Vector3l::Zero();
  Matrix3l covariance = Matrix3l::Zero();

  explicit SurfelBatch(const std::vector<Vector3l>& points) {
    for (const Vector3l& p : points) mean += p;
    mean /= static_cast<long double>(points.size());
    for (const Vector3l& p : points) covariance += (p - mean) * (p - mean).transpose();
    covariance /= static_cast<long double>(points.size());
  }
};

Eigen::Matrix3d covariance_of(const mapping::Surfel& surfel) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d a(static_cast<double>(surfel.axis[i][0]), static_cast<double>(surfel.axis[i][1]),
                            static_cast<double>(surfel.axis[i][2]));
    sum += static_cast<double>(surfel.variance_m2[i]) * a * a.transpose();
  }
  return sum;
}
}  // namespace

TEST_CASE("A cell's Gaussian is that of its points, also a thousand kilometres from the origin") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 200; ++run) {
    const double cell_m = run % 2 == 0 ? 1.6 : draws.uniform(1.0, 5.0);
    testing::OwnedSurfelLayer owned(cell_m, 3, 3, 16, 1);
    const double far = run % 3 == 0 ? 0.0 : 1e6;
    const auto coordinate = [&] { return std::floor(draws.uniform(-far, far) / cell_m); };
    const mapping::SurfelCell cell{{static_cast<std::int32_t>(coordinate()),
                                    static_cast<std::int32_t>(coordinate()),
                                    static_cast<std::int32_t>(coordinate())}};
    const rt::Vector3 centre = owned.layer.centre_m(cell);
    // A slab, drawn about the cell's middle; what would stick out is left out.
    const rt::Vector3 normal = draws.direction();
    const double thick = cell_m * std::pow(10.0, draws.uniform(-4, -1));
    const int count = 3 + static_cast<int>(draws.uniform(0, 300));
    std::vector<rt::Vector3> points;
    std::vector<Vector3l> batch;
    while (static_cast<int>(points.size()) < count) {
      rt::Vector3 p{draws.uniform(-0.49, 0.49), draws.uniform(-0.49, 0.49), draws.uniform(-0.49, 0.49)};
      p = cell_m * p;
      p = p - (rt::dot(p, normal) - thick * draws.normal()) * normal;
      if (std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}) > 0.499 * cell_m) continue;
      const rt::Vector3 at = centre + p;
      points.push_back(at);
      batch.emplace_back(static_cast<long double>(at.x) - centre.x, static_cast<long double>(at.y) - centre.y,
                         static_cast<long double>(at.z) - centre.z);
    }
    owned.insert(points, 1);
    const mapping::Surfel* const surfel = owned.layer.surfel_at(cell);
    REQUIRE(surfel != nullptr);
    REQUIRE(surfel->count == points.size());
    const SurfelBatch twin(batch);
    // A point is rounded down to a step: it is off by up to one in each of three directions.
    const double step = cell_m / mapping::kSurfelSteps;
    for (int i = 0; i < 3; ++i) {
      const double by = static_cast<double>(twin.mean[i]) - static_cast<double>(surfel->mean_m[i]);
      CHECK(by > -1e-6 * cell_m);
      CHECK(by < step + 1e-6 * cell_m);
    }
    // Rounding moves a covariance by what it has in common with the points (less than 2 steps a deviation)
    // and by its own.
    const double deviation = std::sqrt(static_cast<double>(twin.covariance.trace()));
    CHECK((covariance_of(*surfel) - twin.covariance.cast<double>()).norm() <
          4 * step * deviation + 3 * step * step);
    const double least =
        Eigen::SelfAdjointEigenSolver<Matrix3l>(twin.covariance).eigenvalues()[0] > 0
            ? static_cast<double>(Eigen::SelfAdjointEigenSolver<Matrix3l>(twin.covariance).eigenvalues()[0])
            : 0.0;
    CHECK(std::fabs(std::sqrt(static_cast<double>(surfel->variance_m2[0])) - std::sqrt(least)) < 2 * step);
  }
}

TEST_CASE("A cell's Gaussian is exact for whole steps, and for the most points that a cell can have") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (const std::uint32_t count : {1u, 2u, 5u, 999u, 32768u}) {
    for (int run = 0; run < 5; ++run) {
      mapping::SurfelSums sums;
      std::vector<Vector3l> batch;
      // The last run takes the far corners alone, where sums are largest.
      for (std::uint32_t i = 0; i < count; ++i) {
        std::int32_t at[3];
        for (std::int32_t& part : at)
          part =
              run == 4 ? (i % 2 == 0 ? -2048 : 2047) : static_cast<std::int32_t>(draws.uniform(-2048, 2048));
        sums.add(at);
        batch.emplace_back(at[0] * 0.5L / 4096, at[1] * 0.5L / 4096, at[2] * 0.5L / 4096);
      }
      const SurfelBatch twin(batch);
      const mapping::Surfel surfel = mapping::surfel_of(sums, 0.5);
      CHECK(surfel.count == count);
      for (int i = 0; i < 3; ++i)
        CHECK(std::fabs(static_cast<double>(surfel.mean_m[i]) - static_cast<double>(twin.mean[i])) < 1e-7);
      const Eigen::Matrix3d wanted = twin.covariance.cast<double>();
      CHECK((covariance_of(surfel) - wanted).norm() <= 1e-6 * wanted.norm());
    }
  }
}

TEST_CASE("What a cell sums up does not depend on the order of its points") {
  testing::Draws draws(7);
  std::vector<rt::Vector3> points;
  for (int i = 0; i < 300; ++i)
    points.push_back({draws.uniform(0, 3), draws.uniform(-3, 0), draws.uniform(0, 0.2)});
  testing::OwnedSurfelLayer first(0.5, 4, 4, 64);
  first.insert(points, 1);
  for (int run = 0; run < 5; ++run) {
    testing::shuffle(points, draws);
    testing::OwnedSurfelLayer other(0.5, 4, 4, 64);
    other.insert(points, 1);
    CHECK(first.keys == other.keys);
    CHECK(std::memcmp(first.surfels.data(), other.surfels.data(), 64 * sizeof(mapping::Surfel)) == 0);
    CHECK(std::memcmp(first.sums.data(), other.sums.data(), 64 * sizeof(mapping::SurfelSums)) == 0);
  }
}

TEST_CASE("A cell that fades keeps its mean and its covariance, also with an odd number of points") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 200; ++run) {
    const int count = 16 + static_cast<int>(draws.uniform(0, run % 2 == 0 ? 40 : 4000));
    mapping::SurfelSums sums;
    // A thin surface at the cell's rim.
    for (int i = 0; i < count; ++i) {
      const std::int32_t at[3] = {static_cast<std::int32_t>(draws.uniform(-2048, 2048)),
                                  static_cast<std::int32_t>(draws.uniform(-2048, 2048)),
                                  static_cast<std::int32_t>(1900 + 50 * draws.uniform(-1, 1))};
      sums.add(at);
    }
    const mapping::Surfel before = mapping::surfel_of(sums, 0.4);
    sums.fade();
    const mapping::Surfel after = mapping::surfel_of(sums, 0.4);
    INFO("points " << count);
    CHECK(after.count == static_cast<std::uint32_t>(count / 2));
    for (int i = 0; i < 3; ++i)
      CHECK(std::fabs(static_cast<double>(before.mean_m[i]) - static_cast<double>(after.mean_m[i])) < 2e-5);
    CHECK((covariance_of(before) - covariance_of(after)).norm() < 5e-3 * covariance_of(before).norm());
    // The least one most of all: it says how well the surface holds a scan. Sums lose less than a whole step
    // each, so at 1900 steps from the centre the variance may be off by 2 * 1900 / 8 steps squared.
    const double step2 = 0.4 / 4096 * 0.4 / 4096;
    CHECK(std::fabs(static_cast<double>(before.variance_m2[0]) - static_cast<double>(after.variance_m2[0])) <
          2 * 1951.0 / after.count * step2 + 1e-9);
  }
}
