// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/plane_fit.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/plane_algebra.hpp"
#include "mapping/registration/plane_system.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
using rt::cross;
using rt::dot;
using rt::Vector3;

constexpr double kNothingKnown = 1e9;

/// The directions that are solved for, as columns, and where the others must go.
struct Basis {
  double column[7][7]{};
  int columns{};
  double locked[7]{};
};

void lock_turn(const PlaneSystem& system, const PlaneFitInput& in, const PlanePose& pose, PlaneFit& fit,
               Basis& basis) {
  const EigenPairs<3> eigen = eigen_pairs(system.turn.h);
  const rt::Quaternion& q = in.estimate.T_target_source.q_target_source;
  const Vector3 to_estimate = rt::log_rotation(q * rt::conjugate(pose.q_target_source));
  const bool known = in.estimate.has_yaw();
  fit.rotation_rank = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector3 axis{eigen.vector[0][k], eigen.vector[1][k], eigen.vector[2][k]};
    fit.rotation_axis[k] = axis;
    const bool observed = eigen.value[k] > 1.0 / squared(in.config.observed_sigma_rad);
    if (observed) {
      for (int i = 0; i < 3; ++i) basis.column[i][basis.columns] = eigen.vector[i][k];
      ++basis.columns;
      ++fit.rotation_rank;
    } else if (known) {
      for (int i = 0; i < 3; ++i) basis.locked[i] += eigen.vector[i][k] * dot(axis, to_estimate);
    }
  }
}

/// What is left of the offsets' information on (shift, scale) once the observed turns are taken out.
bool reduced(const PlaneSystem& system, const Basis& basis, double lever_m, double (&s)[4][4]) {
  const int m = basis.columns;
  double a[3][3]{};
  double cross_terms[3][4]{};
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < m; ++j) {
      for (int p = 0; p < 3; ++p) {
        for (int q = 0; q < 3; ++q) a[i][j] += basis.column[p][i] * system.whole.h[p][q] * basis.column[q][j];
      }
    }
    for (int j = 0; j < 4; ++j) {
      for (int p = 0; p < 3; ++p) cross_terms[i][j] += basis.column[p][i] * system.whole.h[p][3 + j];
    }
  }
  if (m > 0 && !factorise(a, m)) return false;
  for (int j = 0; j < 4; ++j) {
    double x[3] = {cross_terms[0][j], cross_terms[1][j], cross_terms[2][j]};
    if (m > 0) solve(a, m, x);
    for (int i = 0; i < 4; ++i) {
      s[i][j] = system.whole.h[3 + i][3 + j];
      for (int k = 0; k < m; ++k) s[i][j] -= cross_terms[k][i] * x[k];
    }
  }
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j <= i; ++j) {
      s[i][j] = s[j][i] =
          0.5 * (s[i][j] + s[j][i]) * (i == 3 ? 1.0 / lever_m : 1.0) * (j == 3 ? 1.0 / lever_m : 1.0);
    }
  }
  return true;
}

void lock_shift(const double (&s)[4][4], const PlaneFitInput& in, const PlanePose& pose, PlaneFit& fit,
                Basis& basis) {
  const bool scaled = in.estimate.wants_scale();
  const PlanePose& given = in.estimate.T_target_source;
  const Vector3 to_estimate = transform(given, fit.pivot_source_m) - fit.pivot_target_m;
  const double missing[4] = {to_estimate.x, to_estimate.y, to_estimate.z,
                             scaled ? fit.lever_m * rt::log(given.scale / pose.scale) : 0.0};
  double value[4]{};
  double vector[4][4]{};  // [row][which]
  const int n = scaled ? 4 : 3;
  const auto take = [&]<int N>(const double(&matrix)[N][N]) {
    const EigenPairs<N> eigen = eigen_pairs(matrix);
    for (int k = 0; k < N; ++k) {
      value[k] = eigen.value[k];
      for (int i = 0; i < N; ++i) vector[i][k] = eigen.vector[i][k];
    }
  };
  double three[3][3];
  for (int i = 0; i < 3; ++i) std::copy_n(s[i], 3, three[i]);
  if (scaled)
    take(s);
  else
    take(three);
  fit.translation_rank = 0;
  for (int k = 0; k < n; ++k) {
    double along = 0.0;
    for (int i = 0; i < n; ++i) {
      fit.direction[k][i] = vector[i][k];
      along += vector[i][k] * missing[i];
    }
    const double per_scale = 1.0 / fit.lever_m;
    const double sigma = value[k] > squared(1.0 / kNothingKnown) ? 1.0 / std::sqrt(value[k]) : kNothingKnown;
    fit.direction_sigma_m[k] = sigma;
    if (sigma < in.config.observed_sigma_m) {
      for (int i = 0; i < n; ++i)
        basis.column[3 + i][basis.columns] = vector[i][k] * (i == 3 ? per_scale : 1.0);
      ++basis.columns;
      ++fit.translation_rank;
    } else if (in.estimate.has_position()) {
      for (int i = 0; i < n; ++i) basis.locked[3 + i] += vector[i][k] * along * (i == 3 ? per_scale : 1.0);
    }
  }
}

/// The change that the observed directions take, next to the locked ones; and its covariance.
bool solve_within(const PlaneSystem& system, const Basis& basis, double (&change)[7],
                  double (*covariance)[7]) {
  const int m = basis.columns;
  double a[7][7]{};
  double x[7]{};
  double image[7][7]{};  // H times the columns
  for (int p = 0; p < 7; ++p) {
    for (int j = 0; j < m; ++j) {
      for (int q = 0; q < 7; ++q) image[p][j] += system.whole.h[p][q] * basis.column[q][j];
    }
  }
  double rest[7];
  for (int p = 0; p < 7; ++p) {
    rest[p] = system.whole.g[p];
    for (int q = 0; q < 7; ++q) rest[p] -= system.whole.h[p][q] * basis.locked[q];
  }
  for (int i = 0; i < m; ++i) {
    for (int p = 0; p < 7; ++p) x[i] += basis.column[p][i] * rest[p];
    for (int j = 0; j < m; ++j) {
      for (int p = 0; p < 7; ++p) a[i][j] += basis.column[p][i] * image[p][j];
    }
  }
  if (m > 0 && !factorise(a, m)) return false;
  if (m > 0) solve(a, m, x);
  for (int p = 0; p < 7; ++p) {
    change[p] = basis.locked[p];
    for (int j = 0; j < m; ++j) change[p] += basis.column[p][j] * x[j];
  }
  if (covariance == nullptr) return true;
  double inverse_columns[7][7]{};
  for (int p = 0; p < 7; ++p) {
    double y[7];
    for (int j = 0; j < m; ++j) y[j] = basis.column[p][j];
    if (m > 0) solve(a, m, y);
    for (int j = 0; j < m; ++j) inverse_columns[p][j] = y[j];
  }
  for (int p = 0; p < 7; ++p) {
    for (int q = 0; q < 7; ++q) {
      covariance[p][q] = 0.0;
      for (int j = 0; j < m; ++j) covariance[p][q] += inverse_columns[p][j] * basis.column[q][j];
    }
  }
  return true;
}

/// True where all eigenvalues of a symmetric matrix lie above `least`.
template <int N>
bool all_above(const double (&matrix)[N][N], int n, double least) {
  double a[N][N];
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) a[i][j] = matrix[i][j];
    a[i][i] -= least;
  }
  return factorise(a, n);
}

/// The change where every direction is observed, without looking for directions; false where one may not be.
bool solve_whole(const PlaneSystem& system, const PlaneFitInput& in, double lever_m, double (&change)[7]) {
  if (!all_above(system.turn.h, 3, 1.0 / squared(in.config.observed_sigma_rad))) return false;
  Basis turns;
  for (int i = 0; i < 3; ++i) turns.column[i][i] = 1.0;
  turns.columns = 3;
  const int n = in.estimate.wants_scale() ? 7 : 6;
  double s[4][4];
  if (!reduced(system, turns, lever_m, s) || !all_above(s, n - 3, 1.0 / squared(in.config.observed_sigma_m)))
    return false;
  double a[7][7];
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) a[i][j] = system.whole.h[i][j];
    change[i] = i < n ? system.whole.g[i] : 0.0;
  }
  if (!factorise(a, n)) return false;
  solve(a, n, change);
  return true;
}

bool usable(const PlaneFit& fit) {
  return rt::is_finite(fit.T_target_source.q_target_source) &&
         rt::is_finite(fit.T_target_source.p_target_source_m) && fit.T_target_source.scale > 1e-6 &&
         fit.T_target_source.scale < 1e6 && std::isfinite(fit.chi2);
}
}  // namespace

double offset_variance(const Plane& s, const Plane& t, double scale, double along_u_m, double along_v_m,
                       const PlaneFitConfig& config) {
  return squared(scale * s.sigma_offset_m) + squared(t.sigma_offset_m) +
         squared(along_v_m * t.sigma_tilt_rad[0]) + squared(along_u_m * t.sigma_tilt_rad[1]) +
         squared(config.model_sigma_m);
}

PlaneFit fit_planes(std::span<const Plane> source, std::span<const Plane> target,
                    std::span<const PlanePair> pairs, const PlanePose& start, const PlaneEstimate& estimate,
                    const PlaneFitConfig& config, int steps) {
  const PlaneFitInput in{source, target, pairs, estimate, config};
  PlaneFit fit;
  fit.T_target_source = start;
  for (const PlanePair& pair : pairs)
    fit.pivot_source_m =
        fit.pivot_source_m + (1.0 / static_cast<double>(pairs.size())) * source[pair.source].centroid_m;
  fit.pivot_target_m = transform(start, fit.pivot_source_m);
  for (int step = 0; step < steps; ++step) {
    const PlanePose pose = fit.T_target_source;
    const PlaneSystem system = linearised(in, pose, fit.pivot_target_m, fit.lever_m);
    double change[7];
    bool good = step + 1 < steps && solve_whole(system, in, fit.lever_m, change);
    if (!good) {
      Basis basis;
      double s[4][4];
      lock_turn(system, in, pose, fit, basis);
      good = reduced(system, basis, fit.lever_m, s);
      if (good) {
        lock_shift(s, in, pose, fit, basis);
        good = solve_within(system, basis, change, step + 1 == steps ? fit.covariance : nullptr);
      }
    }
    if (good) {
      fit.T_target_source = changed(pose, fit.pivot_target_m, change);
      fit.pivot_target_m = fit.pivot_target_m + Vector3{change[3], change[4], change[5]};
    }
    fit.chi2 = system.chi2;
    fit.rows = system.rows;
    if (!good || !usable(fit)) {
      fit.T_target_source = start;
      fit.finite = false;
      return fit;
    }
  }
  fit.finite = steps > 0;
  return fit;
}

}  // namespace sortie::mapping
