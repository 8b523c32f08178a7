// SPDX-License-Identifier: BSD-3-Clause
// Matrices of fixed size over any number type, with one order of operations everywhere: what controllers are
// designed with.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "planner/uav_control/double_double.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

// Sizes are arguments here, so that a small board holds this once and not for every size.
namespace detail {

/// out = a b, rows x inner times inner x columns; out is neither of them. Sums run in the order of the
/// columns.
template <class T>
void multiply(const T* a, const T* b, T* out, std::size_t rows, std::size_t inner, std::size_t columns) {
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      T sum{};
      for (std::size_t k = 0; k < inner; ++k) sum = sum + a[r * inner + k] * b[k * columns + c];
      *out++ = sum;
    }
  }
}

template <class T>
void transpose(T* a, std::size_t n) {
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < r; ++c) std::swap(a[r * n + c], a[c * n + r]);
  }
}

template <class T>
void symmetrise(T* a, std::size_t n) {
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c <= r; ++c) a[r * n + c] = a[c * n + r] = T(0.5) * (a[r * n + c] + a[c * n + r]);
  }
}

template <class T>
void add(const T* more, T* to, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] = to[i] + more[i];
}

template <class T>
double row_norm(const T* a, std::size_t rows, std::size_t columns) {
  double most = 0.0;
  for (std::size_t r = 0; r < rows; ++r) {
    double sum = 0.0;
    for (std::size_t c = 0; c < columns; ++c) sum += size_of(*a++);
    if (std::isnan(sum)) return sum;
    if (sum > most) most = sum;
  }
  return most;
}

/// Elimination with row pivots: a is n x n and used up, b is n x columns and becomes a^-1 b.
template <class T>
[[nodiscard]] Status solve(T* a, T* b, std::size_t n, std::size_t columns) {
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t r = k + 1; r < n; ++r) {
      if (size_of(a[r * n + k]) > size_of(a[pivot * n + k])) pivot = r;
    }
    if (!(size_of(a[pivot * n + k]) > 1e-280)) return Status::out_of_range;
    if (pivot != k) {
      std::swap_ranges(a + k * n, a + k * n + n, a + pivot * n);
      std::swap_ranges(b + k * columns, b + k * columns + columns, b + pivot * columns);
    }
    for (std::size_t r = k + 1; r < n; ++r) {
      const T factor = a[r * n + k] / a[k * n + k];
      for (std::size_t c = k + 1; c < n; ++c) a[r * n + c] = a[r * n + c] - factor * a[k * n + c];
      for (std::size_t c = 0; c < columns; ++c)
        b[r * columns + c] = b[r * columns + c] - factor * b[k * columns + c];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t c = 0; c < columns; ++c) {
      T sum = b[k * columns + c];
      for (std::size_t j = k + 1; j < n; ++j) sum = sum - a[k * n + j] * b[j * columns + c];
      b[k * columns + c] = sum / a[k * n + k];
    }
  }
  return Status::ok;
}

}  // namespace detail

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

/// out = a b, into a matrix that is neither.
template <class T, std::size_t R, std::size_t K, std::size_t C>
void multiply(const SmallMatrix<T, R, K>& a, const SmallMatrix<T, K, C>& b, SmallMatrix<T, R, C>& out) {
  detail::multiply(a.m, b.m, out.m, R, K, C);
}

template <class T, std::size_t R, std::size_t K, std::size_t C>
SmallMatrix<T, R, C> operator*(const SmallMatrix<T, R, K>& a, const SmallMatrix<T, K, C>& b) {
  SmallMatrix<T, R, C> out;
  multiply(a, b, out);
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

/// Transposes in place.
template <class T, std::size_t N>
void transpose(SmallMatrix<T, N, N>& a) {
  detail::transpose(a.m, N);
}

/// Takes rounding's asymmetry out, in place.
template <class T, std::size_t N>
void symmetrise(SmallMatrix<T, N, N>& a) {
  detail::symmetrise(a.m, N);
}

/// to = to + more.
template <class T, std::size_t R, std::size_t C>
void add(const SmallMatrix<T, R, C>& more, SmallMatrix<T, R, C>& to) {
  detail::add(more.m, to.m, R * C);
}

/// Largest row sum of sizes; NaN when any number is.
template <class T, std::size_t R, std::size_t C>
double row_norm(const SmallMatrix<T, R, C>& a) {
  return detail::row_norm(a.m, R, C);
}

/// X with a X = b, by elimination with row pivots, in place of b; a is used up. out_of_range when a is
/// singular to working precision; X is then not usable. N^2 (N + C) products.
template <class T, std::size_t N, std::size_t C>
[[nodiscard]] Status solve(SmallMatrix<T, N, N>& a, SmallMatrix<T, N, C>& b) {
  return detail::solve(a.m, b.m, N, C);
}

}  // namespace sortie::planner
