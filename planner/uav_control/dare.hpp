// SPDX-License-Identifier: BSD-3-Clause
// Optimal gains of a linear system in discrete time: the algebraic Riccati equation
// X = A' X A - A' X B (R + B' X B)^-1 B' X A + Q.
#pragma once

#include <cmath>

#include "planner/uav_control/small_matrix.hpp"

namespace sortie::planner {

/// Bounds of the iterations; the defaults serve everything that converges at all.
struct DareLimits {
  int doublings{60};
  int refinements{3};
  double residual{1e-14};  ///< refined until below
};

/// What came out, beside the gain.
struct DareReport {
  int doublings{};
  int refinements{};
  double residual{};  ///< of the equation, relative to the size of X
  bool stable{};      ///< a power of A - B K has a norm below 1, so its spectral radius is below 1
  double radius{};    ///< that bound of the spectral radius
};

template <class T, std::size_t N, std::size_t M>
struct Dare {
  SmallMatrix<T, N, N> a;
  SmallMatrix<T, N, M> b;
  SmallMatrix<T, N, N> q;  ///< symmetric, not negative
  SmallMatrix<T, M, M> r;  ///< symmetric, positive

  /// K = (R + B' X B)^-1 B' X A.
  [[nodiscard]] Status gain(const SmallMatrix<T, N, N>& x, SmallMatrix<T, M, N>& k) const {
    const SmallMatrix<T, M, N> bx = transposed(b) * x;
    return solve(r + bx * b, bx * a, k);
  }

  /// Norm of what is left over of the equation, over that of X.
  double residual(const SmallMatrix<T, N, N>& x, const SmallMatrix<T, M, N>& k) const {
    const SmallMatrix<T, N, N> closed = a - b * k;
    const SmallMatrix<T, N, N> rest = transposed(a) * x * closed + q - x;
    return row_norm(rest) / row_norm(x);
  }

  /// Structure-preserving doubling (Chu, Fan, Lin and Wang 2004): each step stands for twice as many steps of
  /// the value iteration as the one before. out_of_range when it does not settle within the limit.
  [[nodiscard]] Status doubling(SmallMatrix<T, N, N>& x, const DareLimits& limits, DareReport& report) const {
    SmallMatrix<T, M, N> rb;
    if (solve(r, transposed(b), rb) != Status::ok) return Status::out_of_range;
    const SmallMatrix<T, N, N> eye = SmallMatrix<T, N, N>::identity();
    SmallMatrix<T, N, N> step = a;
    SmallMatrix<T, N, N> g = symmetrised(b * rb);
    x = q;
    for (report.doublings = 1; report.doublings <= limits.doublings; ++report.doublings) {
      const SmallMatrix<T, N, N> core = eye + g * x;
      SmallMatrix<T, N, N> step_in;  // (I + G X)^-1 A
      SmallMatrix<T, N, N> g_in;     // (I + G X)^-1 G
      if (solve(core, step, step_in) != Status::ok || solve(core, g, g_in) != Status::ok) break;
      const SmallMatrix<T, N, N> more = symmetrised(transposed(step) * x * step_in);
      g = symmetrised(g + step * g_in * transposed(step));
      step = step * step_in;
      x = x + more;
      const double change = row_norm(more);
      if (!std::isfinite(change)) break;
      if (change <= 1e-30 * row_norm(x)) return Status::ok;
    }
    return Status::out_of_range;
  }

  /// One step of Newton's method (Kleinman 1968, Hewer 1971): the cost of going on with the present gain, by
  /// Smith's doubling. Needs a gain that is stable.
  [[nodiscard]] Status refine(SmallMatrix<T, N, N>& x, const SmallMatrix<T, M, N>& k,
                              const DareLimits& limits) const {
    SmallMatrix<T, N, N> closed = a - b * k;
    SmallMatrix<T, N, N> sum = symmetrised(q + transposed(k) * r * k);
    for (int i = 0; i < limits.doublings; ++i) {
      const SmallMatrix<T, N, N> more = symmetrised(transposed(closed) * sum * closed);
      sum = sum + more;
      closed = closed * closed;
      const double change = row_norm(more);
      if (!std::isfinite(change)) return Status::out_of_range;
      if (change <= 1e-30 * row_norm(sum)) {
        x = sum;
        return Status::ok;
      }
    }
    return Status::out_of_range;
  }

  /// Whether A - B K is stable: its powers are squared until one is shorter than 1, which bounds the spectral
  /// radius from above (Gelfand). At most 60 squarings.
  void judge(const SmallMatrix<T, M, N>& k, DareReport& report) const {
    SmallMatrix<T, N, N> power = a - b * k;
    report.stable = false;
    report.radius = row_norm(power);
    for (int i = 0; i < 60; ++i) {
      const double norm = row_norm(power);
      if (!(norm < 1e60)) return;
      if (norm < 0.5) {
        report.radius = norm;
        for (int j = 0; j < i; ++j) report.radius = std::sqrt(report.radius);
        report.stable = report.radius < 1.0;
        return;
      }
      power = power * power;
    }
  }

  /// The optimal gain: doubling, then refinement until the residual is below the limit. out_of_range when the
  /// iterations did not settle, the residual stays above 1e-10 or the result is not stable.
  [[nodiscard]] Status solve_gain(SmallMatrix<T, M, N>& k, DareReport& report,
                                  const DareLimits& limits = {}) const {
    SmallMatrix<T, N, N> x;
    const Status doubled = doubling(x, limits, report);
    if (doubled != Status::ok) return doubled;
    if (gain(x, k) != Status::ok) return Status::out_of_range;
    report.residual = residual(x, k);
    for (report.refinements = 0;
         report.refinements < limits.refinements && !(report.residual <= limits.residual);
         ++report.refinements) {
      if (refine(x, k, limits) != Status::ok || gain(x, k) != Status::ok) return Status::out_of_range;
      report.residual = residual(x, k);
    }
    judge(k, report);
    return report.stable && report.residual <= 1e-10 ? Status::ok : Status::out_of_range;
  }
};

}  // namespace sortie::planner
