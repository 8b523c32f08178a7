// SPDX-License-Identifier: BSD-3-Clause
// Eigen's decompositions of small matrices, to judge by. They are compiled once, and few of them: each kind
// of matrix costs seconds, and a file that asks Eigen itself takes up to half a minute to compile.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sortie::testing {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Of a symmetric matrix: values rise, vectors are columns.
struct Eigen3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};
Eigen3 eigen_of(const Eigen::Matrix3d& symmetric);
/// Rising.
Vector6 eigenvalues_of(const Matrix6& symmetric);
/// x of a x = b, by LDLT.
Eigen::VectorXd solved(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/// a = u diag(values) v^T, thin; values fall.
struct Singular {
  Eigen::VectorXd values;
  Eigen::MatrixXd u, v;
};
Singular singular_of(const Eigen::MatrixXd& a);
/// x of the least |a x - b|, by singular values.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/// Of a square matrix, by singular values.
Eigen::MatrixXd inverted(const Eigen::MatrixXd& a);

}  // namespace sortie::testing
