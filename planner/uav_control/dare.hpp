// SPDX-License-Identifier: BSD-3-Clause
// Optimal gains of a linear system in discrete time: the algebraic Riccati equation
// X = A' X A - A' X B (R + B' X B)^-1 B' X A + Q.
#pragma once

#include <cmath>

#include "planner/uav_control/small_matrix.hpp"

namespace sortie::planner {

/// Bounds of the iterations; they serve everything that converges at all.
inline constexpr int kMostDoublings = 60;
inline constexpr int kMostRefinements = 3;
inline constexpr double kGoodResidual = 1e-14;  ///< refined until below

/// What came out, beside the gain.
struct DareReport {
  int doublings{};
  int refinements{};
  double residual{};  ///< of the equation, relative to the size of X
  bool stable{};      ///< a power of A - B K has a norm below 1, so its spectral radius is below 1
  double radius{};    ///< that bound of the spectral radius
};

/// The equation of a system with N states and M inputs. A gain takes some thousand products of N x N
/// matrices' numbers and ten such matrices of stack; set-up only.
template <class T, std::size_t N, std::size_t M>
struct Dare {
  SmallMatrix<T, N, N> a;
  SmallMatrix<T, N, M> b;
  SmallMatrix<T, N, N> q;  ///< symmetric, not negative
  SmallMatrix<T, M, M> r;  ///< symmetric, positive

  /// K = (R + B' X B)^-1 B' X A.
  [[nodiscard]] Status gain(const SmallMatrix<T, N, N>& x, SmallMatrix<T, M, N>& k) const {
    const SmallMatrix<T, M, N> bx = transposed(b) * x;
    SmallMatrix<T, M, M> weight = bx * b;
    add(r, weight);
    multiply(bx, a, k);
    return solve(weight, k);
  }

  /// Norm of what is left over of the equation, over that of X.
  double residual(const SmallMatrix<T, N, N>& x, const SmallMatrix<T, M, N>& k) const {
    SmallMatrix<T, N, N> closed;
    SmallMatrix<T, N, N> a_x = a;
    SmallMatrix<T, N, N> rest;
    transpose(a_x);
    multiply(a_x, x, rest);
    a_x = rest;
    close(k, closed);
    multiply(a_x, closed, rest);
    for (std::size_t i = 0; i < N * N; ++i) rest.m[i] = rest.m[i] + q.m[i] - x.m[i];
    return row_norm(rest) / row_norm(x);
  }

  /// Structure-preserving doubling (Chu, Fan, Lin and Wang 2004): each step stands for twice as many steps of
  /// the value iteration as the one before. out_of_range when it does not settle within the limit.
  [[nodiscard]] Status doubling(SmallMatrix<T, N, N>& x, DareReport& report) const {
    SmallMatrix<T, N, N> step = a;
    SmallMatrix<T, N, N> g;
    if (spread_input(g) != Status::ok) return Status::out_of_range;
    SmallMatrix<T, N, N> step_in;  // (I + G X)^-1 A
    SmallMatrix<T, N, N> g_in;     // (I + G X)^-1 G
    SmallMatrix<T, N, N> core;
    SmallMatrix<T, N, N> work;
    x = q;
    for (report.doublings = 1; report.doublings <= kMostDoublings; ++report.doublings) {
      multiply(g, x, core);
      for (std::size_t i = 0; i < N; ++i) core(i, i) = T(1.0) + core(i, i);
      work = core;
      step_in = step;
      g_in = g;
      if (solve(work, step_in) != Status::ok || solve(core, g_in) != Status::ok) break;
      // G + A G' A^T, with G' = (I + G X)^-1 G.
      multiply(step, g_in, work);
      transpose(step);
      multiply(work, step, g_in);
      add(g_in, g);
      symmetrise(g);
      // X + A^T X A', with A' = (I + G X)^-1 A.
      multiply(step, x, work);
      multiply(work, step_in, core);
      symmetrise(core);
      transpose(step);
      multiply(step, step_in, work);
      step = work;
      add(core, x);
      const double change = row_norm(core);
      if (!std::isfinite(change)) break;
      if (change <= 1e-30 * row_norm(x)) return Status::ok;
    }
    return Status::out_of_range;
  }

  /// One step of Newton's method (Kleinman 1968, Hewer 1971): the cost of going on with the present gain, by
  /// Smith's doubling. Needs a gain that is stable.
  [[nodiscard]] Status refine(SmallMatrix<T, N, N>& x, const SmallMatrix<T, M, N>& k) const {
    SmallMatrix<T, N, N> closed;
    SmallMatrix<T, N, N> sum;
    SmallMatrix<T, N, N> more;
    SmallMatrix<T, N, N> work;
    close(k, closed);
    multiply(transposed(k) * r, k, sum);
    add(q, sum);
    symmetrise(sum);
    for (int i = 0; i < kMostDoublings; ++i) {
      transpose(closed);
      multiply(closed, sum, work);
      transpose(closed);
      multiply(work, closed, more);
      symmetrise(more);
      add(more, sum);
      multiply(closed, closed, work);
      closed = work;
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
    SmallMatrix<T, N, N> power;
    SmallMatrix<T, N, N> work;
    close(k, power);
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
      multiply(power, power, work);
      power = work;
    }
  }

  /// The optimal gain: doubling, then refinement until the residual is below the limit. out_of_range when the
  /// iterations did not settle, the residual stays above 1e-10 or the result is not stable.
  [[nodiscard]] Status solve_gain(SmallMatrix<T, M, N>& k, DareReport& report) const {
    SmallMatrix<T, N, N> x;
    const Status doubled = doubling(x, report);
    if (doubled != Status::ok) return doubled;
    if (gain(x, k) != Status::ok) return Status::out_of_range;
    report.residual = residual(x, k);
    for (report.refinements = 0; report.refinements < kMostRefinements && !(report.residual <= kGoodResidual);
         ++report.refinements) {
      if (refine(x, k) != Status::ok || gain(x, k) != Status::ok) return Status::out_of_range;
      report.residual = residual(x, k);
    }
    judge(k, report);
    return report.stable && report.residual <= 1e-10 ? Status::ok : Status::out_of_range;
  }

 private:
  // A - B K.
  void close(const SmallMatrix<T, M, N>& k, SmallMatrix<T, N, N>& closed) const {
    multiply(b, k, closed);
    for (std::size_t i = 0; i < N * N; ++i) closed.m[i] = a.m[i] - closed.m[i];
  }
  // B R^-1 B^T.
  [[nodiscard]] Status spread_input(SmallMatrix<T, N, N>& g) const {
    SmallMatrix<T, M, N> rb = transposed(b);
    SmallMatrix<T, M, M> weight = r;
    if (solve(weight, rb) != Status::ok) return Status::out_of_range;
    multiply(b, rb, g);
    symmetrise(g);
    return Status::ok;
  }
};

}  // namespace sortie::planner
