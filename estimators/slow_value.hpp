// SPDX-License-Identifier: BSD-3-Clause
// Second-order low-pass over steps of any length: the mean of what came so far until one time constant has
// passed, a Butterworth filter from then on.
#pragma once

#include "estimators/real_rotation.hpp"

namespace sortie::estimators {

/// One step of a family of low-passes that share time constant and age. One division for all of them.
template <class Real>
struct SlowStep {
  Real weight{};   ///< while averaging: weight of the new value; 0 afterwards
  Real half{};     ///< half of cut-off times step
  Real inverse{};  ///< of the denominator

  /// `dt_s` after `age_s` of earlier steps. Cut-off sqrt(2) / tau rad/s, as VQF has it; the trapezoidal rule
  /// is stable for any step and needs no exponential, so that steps may differ.
  SlowStep(Real dt_s, Real age_s, Real tau_s) {
    if (age_s < tau_s) {
      weight = dt_s / (age_s + dt_s);
    } else {
      constexpr Real kRoot = Real(1.4142135623730951);
      half = Real{0.5} * kRoot * dt_s / tau_s;
      inverse = Real{1} / (Real{1} + half * (kRoot + half));
    }
  }
};

/// A low-passed number: value, and slope over cut-off (same unit).
template <class Real>
struct SlowValue {
  Real value{};
  Real slope{};
  SORTIE_FIELDS(value, slope)

  /// `in` is the mean of the input over the step.
  void take(Real in, const SlowStep<Real>& step) {
    if (step.weight > Real{0}) {
      value += step.weight * (in - value);
      slope = Real{0};
      return;
    }
    const Real sum = Real{2} * step.inverse * (slope + step.half * (in - value));
    value += step.half * sum;
    slope = sum - slope;
  }
};

/// Three of them.
template <class Real>
struct SlowVector {
  SlowValue<Real> x, y, z;
  SORTIE_FIELDS(x, y, z)

  void take(const VectorOf<Real>& in, const SlowStep<Real>& step) {
    x.take(in.x, step);
    y.take(in.y, step);
    z.take(in.z, step);
  }
  VectorOf<Real> value() const { return {x.value, y.value, z.value}; }
  VectorOf<Real> slope() const { return {x.slope, y.slope, z.slope}; }
  void set(const VectorOf<Real>& value, const VectorOf<Real>& slope) {
    x = {value.x, slope.x};
    y = {value.y, slope.y};
    z = {value.z, slope.z};
  }
};

}  // namespace sortie::estimators
