// SPDX-License-Identifier: BSD-3-Clause
// Small symmetric matrices: sums of rows, eigenvectors by Jacobi's rotations and systems by Cholesky's
// factors, in a fixed number of steps and with the same bits everywhere.
#pragma once

#include <cmath>
#include <utility>

namespace sortie::mapping {

constexpr double squared(double v) { return v * v; }

/// Sums over weighted rows of N unknowns: the change x that makes their residuals least has h x = g.
template <int N>
struct LeastSquares {
  double h[N][N]{};  ///< its lower half, until fill()
  double g[N]{};

  void add(const double (&j)[N], double residual, double weight) {
    for (int a = 0; a < N; ++a) {
      const double wj = weight * j[a];
      for (int b = 0; b <= a; ++b) h[a][b] += wj * j[b];
      g[a] -= wj * residual;
    }
  }
  void fill() {
    for (int a = 0; a < N; ++a) {
      for (int b = a + 1; b < N; ++b) h[a][b] = h[b][a];
    }
  }
};

/// Eigenvalues in rising order, and their eigenvectors as columns of `vector`.
template <int N>
struct EigenPairs {
  double value[N]{};
  double vector[N][N]{};  ///< [row][which]
};

/// Of a symmetric N x N matrix, by cyclic Jacobi rotations: at most 12 sweeps, 4 as a rule; relative error of
/// the eigenvalues about 1e-15 of the largest. Equal eigenvalues keep the order of their columns. About 0.4
/// us for N = 3. Source: G. Golub, C. Van Loan, Matrix Computations, 8.5.
template <int N>
EigenPairs<N> eigen_pairs(const double (&matrix)[N][N]) {
  double a[N][N];
  EigenPairs<N> out;
  double scale = 0.0;
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      a[i][j] = matrix[i][j];
      out.vector[i][j] = i == j ? 1.0 : 0.0;
      scale += a[i][j] * a[i][j];
    }
  }
  for (int sweep = 0; sweep < 12; ++sweep) {
    double rest = 0.0;
    for (int i = 0; i < N; ++i) {
      for (int j = i + 1; j < N; ++j) rest += a[i][j] * a[i][j];
    }
    if (!(rest > 1e-34 * scale)) break;
    for (int p = 0; p < N; ++p) {
      for (int q = p + 1; q < N; ++q) {
        if (a[p][q] == 0.0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
        const double t = (theta < 0.0 ? -1.0 : 1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0);
        const double s = t * c;
        for (int k = 0; k < N; ++k) {
          const double kp = a[k][p];
          const double kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < N; ++k) {
          const double pk = a[p][k];
          const double qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
          const double vp = out.vector[k][p];
          const double vq = out.vector[k][q];
          out.vector[k][p] = c * vp - s * vq;
          out.vector[k][q] = s * vp + c * vq;
        }
        a[p][q] = a[q][p] = 0.0;
      }
    }
  }
  int order[N];
  for (int i = 0; i < N; ++i) order[i] = i;
  for (int i = 1; i < N; ++i) {
    for (int k = i; k > 0 && a[order[k]][order[k]] < a[order[k - 1]][order[k - 1]]; --k)
      std::swap(order[k], order[k - 1]);
  }
  const EigenPairs<N> found = out;
  for (int i = 0; i < N; ++i) {
    out.value[i] = a[order[i]][order[i]];
    for (int k = 0; k < N; ++k) out.vector[k][i] = found.vector[k][order[i]];
  }
  return out;
}

/// Lower factor L of the leading n x n part of a symmetric positive matrix, A = L L^T, in place. False where
/// a pivot is not above `least` of its diagonal element; then `a` is spoilt.
template <int N>
bool factorise(double (&a)[N][N], int n, double least = 0.0) {
  for (int j = 0; j < n; ++j) {
    double pivot = a[j][j];
    for (int k = 0; k < j; ++k) pivot -= a[j][k] * a[j][k];
    if (!(pivot > least * a[j][j])) return false;
    const double root = std::sqrt(pivot);
    a[j][j] = root;
    for (int i = j + 1; i < n; ++i) {
      double sum = a[i][j];
      for (int k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
      a[i][j] = sum / root;
    }
  }
  return true;
}

/// x := (L L^T)^-1 x with what factorise() left.
template <int N>
void solve(const double (&l)[N][N], int n, double* x) {
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= l[i][k] * x[k];
    x[i] /= l[i][i];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) x[i] -= l[k][i] * x[k];
    x[i] /= l[i][i];
  }
}

}  // namespace sortie::mapping
