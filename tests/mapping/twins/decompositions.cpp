// SPDX-License-Identifier: BSD-3-Clause
#include "tests/mapping/twins/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace sortie::testing {

Eigen3 eigen_of(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}
Vector6 eigenvalues_of(const Matrix6& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Matrix6>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}
Eigen::VectorXd solved(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return a.ldlt().solve(b); }
Singular singular_of(const Eigen::MatrixXd& a) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.jacobiSvd(Eigen::ComputeThinU | Eigen::ComputeThinV).solve(b);
}
Eigen::MatrixXd inverted(const Eigen::MatrixXd& a) {
  const Singular svd = singular_of(a);
  return svd.v * svd.values.cwiseInverse().asDiagonal() * svd.u.transpose();
}

}  // namespace sortie::testing
