// SPDX-License-Identifier: BSD-3-Clause
// Sums of cells in whole numbers, beside Eigen's moments in double.
#include "mapping/registration/plane_cell.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/mapping/twins/decompositions.hpp"
#include "tests/mapping/world_random.hpp"

using namespace sortie;

TEST_CASE("Sums of a plane are exact: adding, shifting and taking away leave nothing, moments are Eigen's") {
  tests::WorldRandom random(61);
  for (int trial = 0; trial < 200; ++trial) {
    mapping::PlaneSums sums;
    std::vector<mapping::PlaneSums> parts;
    const std::int64_t d[3] = {random.below(1000000), -std::int64_t{random.below(1000000)},
                               random.below(1000000)};
    const std::int64_t back[3] = {-d[0], -d[1], -d[2]};
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d product = Eigen::Matrix3d::Zero();
    double weight = 0;
    for (int k = 0; k < 50; ++k) {
      const double a = random.between(-20, 20), b = random.between(-20, 20),
                   c = 0.3 * a + 0.01 * random.normal();
      mapping::PlaneCell cell;
      for (float& n : cell.normal) n = 0;
      cell.normal[2] = 1;
      cell.count = 1 + random.below(30);
      const double at[3] = {a, b, c};
      std::int64_t cells[3];
      for (int i = 0; i < 3; ++i) {
        cells[i] = static_cast<std::int64_t>(std::floor(at[i] / 0.4));
        cell.mean_m[i] = static_cast<float>(at[i] - 0.4 * (static_cast<double>(cells[i]) + 0.5));
      }
      mapping::PlaneSums own = mapping::sums_of(cell, 0.4, 64);
      const std::int64_t to_anchor[3] = {1024 * cells[0], 1024 * cells[1], 1024 * cells[2]};
      own.shift(to_anchor);
      sums.add(own);
      parts.push_back(own);
      const double w = cell.count;
      const Eigen::Vector3d x(a, b, c);
      mean += w * x;
      product += w * x * x.transpose();
      weight += w;
    }
    mean /= weight;
    const testing::Eigen3 eigen = testing::eigen_of(product / weight - mean * mean.transpose());
    const mapping::PlaneMoments m = mapping::moments_of(sums, 0.4);
    const Eigen::Vector3d n(m.normal.x, m.normal.y, m.normal.z);
    CHECK(n.cross(eigen.vectors.col(0)).norm() < 1e-4);
    CHECK(m.mean_m.x == Approx(mean.x() - 0.2).margin(5e-4));
    CHECK(m.variance_m2[2] == Approx(eigen.values[2]).epsilon(1e-3));
    mapping::PlaneSums far = sums;
    far.shift(d);
    const mapping::PlaneMoments there = mapping::moments_of(far, 0.4);
    CHECK(there.normal.x == m.normal.x);  // the same bits at any distance
    CHECK(there.variance_m2[0] == m.variance_m2[0]);
    far.shift(back);
    random.shuffle(parts);
    for (const mapping::PlaneSums& part : parts) far.add(part, -1);
    CHECK(far.weight == 0);
    for (const std::int64_t part : far.sum) CHECK(part == 0);
    for (const std::int64_t part : far.product) CHECK(part == 0);
  }
}
