// SPDX-License-Identifier: BSD-3-Clause
// Matrices of fixed size over any number type, with one order of operations everywhere: what controllers are
// designed with.
#pragma once

#include <cmath>
#include <cstddef>

#include "planner/uav_control/double_double.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// R x C numbers, row by row. Zero at the start. No heap; sums run in the order of the columns.
template <class T, std::size_t R, std::size_t C>
struct SmallMatrix {
  T m[R * C]{};

  T& operator()(std::size_t r, std::size_t c) { return m[r * C + c]; }
  const T& operator()(std::size_t r, std::size_t c) const { return m[r * C + c]; }

  static SmallMatrix identity() {
    SmallMatrix eye;
    for (std::size_t i = 0; i < R && i < C; ++i) eye(i, i) = T(1.0);
    return eye;
  }
};

template <class T, std::size_t R, std::size_t C>
SmallMatrix<T, R, C> operator+(SmallMatrix<T, R, C> a, const SmallMatrix<T, R, C>& b) {
  for (std::size_t i = 0; i < R * C; ++i) a.m[i] = a.m[i] + b.m[i];
  return a;
}

template <class T, std::size_t R, std::size_t C>
SmallMatrix<T, R, C> operator-(SmallMatrix<T, R, C> a, const SmallMatrix<T, R, C>& b) {
  for (std::size_t i = 0; i < R * C; ++i) a.m[i] = a.m[i] - b.m[i];
  return a;
}

template <class T, std::size_t R, std::size_t C>
SmallMatrix<T, R, C> scaled(SmallMatrix<T, R, C> a, const T& s) {
  for (T& value : a.m) value = s * value;
  return a;
}

template <class T, std::size_t R, std::size_t K, std::size_t C>
SmallMatrix<T, R, C> operator*(const SmallMatrix<T, R, K>& a, const SmallMatrix<T, K, C>& b) {
  SmallMatrix<T, R, C> out;
  for (std::size_t r = 0; r < R; ++r) {
    for (std::size_t k = 0; k < K; ++k) {
      for (std::size_t c = 0; c < C; ++c) out(r, c) = out(r, c) + a(r, k) * b(k, c);
    }
  }
  return out;
}

template <class T, std::size_t R, std::size_t C>
SmallMatrix<T, C, R> transposed(const SmallMatrix<T, R, C>& a) {
  SmallMatrix<T, C, R> out;
  for (std::size_t r = 0; r < R; ++r) {
    for (std::size_t c = 0; c < C; ++c) out(c, r) = a(r, c);
  }
  return out;
}

/// The same with rounding's asymmetry taken out.
template <class T, std::size_t N>
SmallMatrix<T, N, N> symmetrised(const SmallMatrix<T, N, N>& a) {
  SmallMatrix<T, N, N> out;
  for (std::size_t r = 0; r < N; ++r) {
    for (std::size_t c = 0; c < N; ++c) out(r, c) = T(0.5) * (a(r, c) + a(c, r));
  }
  return out;
}

/// Largest row sum of sizes; NaN when any number is.
template <class T, std::size_t R, std::size_t C>
double row_norm(const SmallMatrix<T, R, C>& a) {
  double most = 0.0;
  for (std::size_t r = 0; r < R; ++r) {
    double sum = 0.0;
    for (std::size_t c = 0; c < C; ++c) sum += size_of(a(r, c));
    if (std::isnan(sum)) return sum;
    if (sum > most) most = sum;
  }
  return most;
}

/// X with a X = b, by elimination with row pivots; a is N x N. out_of_range when a is singular to working
/// precision; X is then not usable. N^2 (N + C) products.
template <class T, std::size_t N, std::size_t C>
[[nodiscard]] Status solve(SmallMatrix<T, N, N> a, SmallMatrix<T, N, C> b, SmallMatrix<T, N, C>& x) {
  for (std::size_t k = 0; k < N; ++k) {
    std::size_t pivot = k;
    for (std::size_t r = k + 1; r < N; ++r) {
      if (size_of(a(r, k)) > size_of(a(pivot, k))) pivot = r;
    }
    if (!(size_of(a(pivot, k)) > 1e-280)) return Status::out_of_range;
    for (std::size_t c = 0; pivot != k && c < N; ++c) {
      const T keep = a(k, c);
      a(k, c) = a(pivot, c);
      a(pivot, c) = keep;
    }
    for (std::size_t c = 0; pivot != k && c < C; ++c) {
      const T keep = b(k, c);
      b(k, c) = b(pivot, c);
      b(pivot, c) = keep;
    }
    for (std::size_t r = k + 1; r < N; ++r) {
      const T factor = a(r, k) / a(k, k);
      for (std::size_t c = k + 1; c < N; ++c) a(r, c) = a(r, c) - factor * a(k, c);
      for (std::size_t c = 0; c < C; ++c) b(r, c) = b(r, c) - factor * b(k, c);
    }
  }
  for (std::size_t k = N; k-- > 0;) {
    for (std::size_t c = 0; c < C; ++c) {
      T sum = b(k, c);
      for (std::size_t j = k + 1; j < N; ++j) sum = sum - a(k, j) * x(j, c);
      x(k, c) = sum / a(k, k);
    }
  }
  return Status::ok;
}

}  // namespace sortie::planner
