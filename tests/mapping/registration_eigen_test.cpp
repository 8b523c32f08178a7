// SPDX-License-Identifier: BSD-3-Clause
// Eigenvalues and eigenvectors of 3x3 matrices against Eigen's own.
#include <catch2/catch.hpp>

#include "mapping/registration/symmetric_eigen.hpp"
#include "tests/mapping/registration_world.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace {
using namespace sortie;

/// Whether values and vectors are those of the matrix, to `within` of its largest value.
void judge_eigen(const Eigen::Matrix3d& m, double within = 2e-14) {
  const mapping::SymmetricEigen found =
      mapping::symmetric_eigen({m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)});
  const testing::Eigen3 twin = testing::eigen_of(m);
  const double scale = std::max(twin.values.cwiseAbs().maxCoeff(), 1e-300);
  Eigen::Matrix3d v;
  for (int i = 0; i < 3; ++i) {
    CHECK(std::fabs(found.value[i] - twin.values[i]) <= within * scale);
    if (i > 0) CHECK(found.value[i - 1] <= found.value[i]);
    for (int j = 0; j < 3; ++j) v(j, i) = found.vector[i][j];
    const double first = v(2, i) != 0.0 ? v(2, i) : v(1, i) != 0.0 ? v(1, i) : v(0, i);
    CHECK(first > 0.0);
    CHECK((m * v.col(i) - found.value[i] * v.col(i)).norm() <= 2 * within * scale);
  }
  CHECK((v.transpose() * v - Eigen::Matrix3d::Identity()).norm() <= within);
}

Eigen::Matrix3d drawn_turn(testing::Draws& draws) {
  const rt::Vector3 axis = draws.direction();
  return Eigen::AngleAxisd(draws.uniform(-3.2, 3.2), Eigen::Vector3d(axis.x, axis.y, axis.z))
      .toRotationMatrix();
}
}  // namespace

TEST_CASE(
    "Eigenvalues and eigenvectors of random symmetric matrices of any size are those that Eigen finds") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 400; ++run) {
    const double scale = std::pow(10.0, draws.uniform(-12, 12));
    Eigen::Matrix3d m;
    for (int i = 0; i < 3; ++i) {
      for (int k = i; k < 3; ++k) m(i, k) = m(k, i) = scale * draws.normal();
    }
    judge_eigen(m);
    // Of any shape: what a long wall's and a thin one's points make.
    const Eigen::Matrix3d r = drawn_turn(draws);
    const Eigen::Vector3d values(std::pow(10.0, draws.uniform(-16, 0)), std::pow(10.0, draws.uniform(-16, 0)),
                                 1.0);
    m = scale * r * values.asDiagonal() * r.transpose();
    judge_eigen(0.5 * (m + m.transpose()));
  }
}

TEST_CASE("Eigenvectors stay square to each other where values are equal, zero or negative") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  const double shapes[][3] = {{0, 0, 0}, {0, 0, 1}, {0, 1, 1},  {1, 1, 1},          {1, 1, 2},
                              {1, 2, 2}, {0, 1, 2}, {-1, 0, 1}, {1, 1, 1.00000001}, {1, 1 + 1e-15, 1e8}};
  for (const double scale : {1e-12, 1.0, 1e12}) {
    for (const auto& shape : shapes) {
      const Eigen::Vector3d values = scale * Eigen::Vector3d(shape[0], shape[1], shape[2]);
      judge_eigen(values.asDiagonal());
      for (int run = 0; run < 10; ++run) {
        const Eigen::Matrix3d r = drawn_turn(draws);
        const Eigen::Matrix3d m = r * values.asDiagonal() * r.transpose();
        judge_eigen(0.5 * (m + m.transpose()));
        // One product of a vector with itself: rank one to the last bit.
        const Eigen::Vector3d v = scale * r.col(0);
        judge_eigen(v * v.transpose());
      }
    }
  }
}
