// SPDX-License-Identifier: BSD-3-Clause
// From a continuous linear system to its exact steps: the matrix exponential.
#pragma once

#include "planner/uav_control/small_matrix.hpp"

namespace sortie::planner {

inline constexpr int kMaxSquarings = 64;

/// e^a by scaling to a norm of at most 1/2, the Taylor series to the given order and squaring back (Moler and
/// Van Loan 2003, method 3). The rest of the series is below 1e-33 at order 24. At most kMaxSquarings: a norm
/// above 2^63 or a NaN gives out_of_range. Set-up only: N^3 products per order and squaring.
template <class T, std::size_t N>
[[nodiscard]] Status matrix_exponential(SmallMatrix<T, N, N> a, SmallMatrix<T, N, N>& out, int order = 24) {
  double norm = row_norm(a);
  int squarings = 0;
  double scale = 1.0;
  while (norm > 0.5 && squarings < kMaxSquarings) {
    norm *= 0.5;
    scale *= 0.5;
    ++squarings;
  }
  if (!(norm <= 0.5)) return Status::out_of_range;
  for (T& value : a.m) value = T(scale) * value;
  // Horner's scheme: I + a (I + a/2 (I + a/3 (...))).
  SmallMatrix<T, N, N> work;
  out = SmallMatrix<T, N, N>::identity();
  for (int k = order; k >= 1; --k) {
    const T share = T(1.0) / T(static_cast<double>(k));
    multiply(a, out, work);
    for (T& value : work.m) value = share * value;
    for (std::size_t i = 0; i < N; ++i) work(i, i) = T(1.0) + work(i, i);
    out = work;
  }
  for (int i = 0; i < squarings; ++i) {
    multiply(out, out, work);
    out = work;
  }
  return Status::ok;
}

/// x' = A x + B u with u held over steps of dt_s: x+ = Ad x + Bd u. Both come from one exponential of the
/// augmented matrix [A B; 0 0] dt, never from an inverse of A, which may be singular.
template <class T, std::size_t N, std::size_t M>
[[nodiscard]] Status discretise(const SmallMatrix<T, N, N>& a, const SmallMatrix<T, N, M>& b, double dt_s,
                                SmallMatrix<T, N, N>& ad, SmallMatrix<T, N, M>& bd) {
  SmallMatrix<T, N + M, N + M> whole;
  for (std::size_t r = 0; r < N; ++r) {
    for (std::size_t c = 0; c < N; ++c) whole(r, c) = T(dt_s) * a(r, c);
    for (std::size_t c = 0; c < M; ++c) whole(r, N + c) = T(dt_s) * b(r, c);
  }
  SmallMatrix<T, N + M, N + M> step;
  const Status status = matrix_exponential(whole, step);
  for (std::size_t r = 0; r < N; ++r) {
    for (std::size_t c = 0; c < N; ++c) ad(r, c) = step(r, c);
    for (std::size_t c = 0; c < M; ++c) bd(r, c) = step(r, N + c);
  }
  return status;
}

}  // namespace sortie::planner
