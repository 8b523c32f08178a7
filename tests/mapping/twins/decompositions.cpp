// SPDX-License-Identifier: BSD-3-Clause
#include "tests/mapping/twins/decompositions.hpp"

#include <Eigen/Dense>

namespace sortie::testing {

Eigen3 eigen_of(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}
Vector6 eigenvalues_of(const Matrix6& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Matrix6>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}
Eigen::Vector3d solved3(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) { return a.ldlt().solve(b); }
Vector6 solved6(const Matrix6& a, const Vector6& b) { return a.ldlt().solve(b); }
Eigen::VectorXd solved(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return a.ldlt().solve(b); }
Singular singular_of(const Eigen::MatrixXd& a) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.jacobiSvd(Eigen::ComputeThinU | Eigen::ComputeThinV).solve(b);
}
Matrix6 inverted(const Matrix6& a) { return a.inverse(); }
Matrix6 orthogonal(const Matrix6& a) { return a.householderQr().householderQ(); }

}  // namespace sortie::testing
