// SPDX-License-Identifier: BSD-3-Clause
// The gyro bias as a Kalman filter, and what its uncertainty makes of the heading.
#pragma once

#include <algorithm>

#include "estimators/real_rotation.hpp"

namespace sortie::estimators {

/// Three biases in the body, observed one direction at a time, and the variance of a heading that is the
/// integral of the vertical rate: it grows with the bias that is not known, and shrinks when that becomes
/// known. rad/s and rad. 16 numbers.
template <class Real>
class GyroBias {
 public:
  GyroBias() = default;
  GyroBias(const VectorOf<Real>& bias, Real variance)
      : bias_(bias), xx_(variance), yy_(variance), zz_(variance) {}

  const VectorOf<Real>& value() const { return bias_; }
  Real heading_variance() const { return heading_; }
  /// Covariance of the bias along `a` with that along `b`.
  Real covariance_along(const VectorOf<Real>& a, const VectorOf<Real>& b) const { return dot(a, times(b)); }

  /// The bias walks; above `most` it is not let grow.
  void grow(Real variance, Real most) {
    if (xx_ < most) xx_ += variance;
    if (yy_ < most) yy_ += variance;
    if (zz_ < most) zz_ += variance;
  }

  /// `dt_s` of integration with the vertical in the body at `up`, and white noise that adds `noise` rad^2.
  void integrate(const VectorOf<Real>& up, Real dt_s, Real noise) {
    const VectorOf<Real> step = dt_s * times(up);
    heading_ += noise + dt_s * (dot(up, step) - Real{2} * dot(up, with_heading_));
    with_heading_ = with_heading_ - step;
  }
  /// A turn of unknown size.
  void add_heading(Real variance) { heading_ += variance; }
  /// The heading is known anew.
  void set_heading(Real variance) {
    heading_ = variance;
    with_heading_ = {};
  }

  /// `seen` = bias along `row`, with noise of variance `noise`; the difference is taken within +-`most`, and
  /// so is each bias afterwards. One division. Returns by how much the heading should turn: while the bias
  /// was not known the heading went wrong with it.
  Real observe(const VectorOf<Real>& row, Real seen, Real noise, Real most) {
    const VectorOf<Real> p = times(row);
    const Real inverse = Real{1} / (dot(row, p) + noise);
    const Real gain = inverse * dot(row, with_heading_);
    const Real difference = std::clamp(seen - dot(row, bias_), -most, most);
    add_exactly(bias_.x, rounding_.x, inverse * difference * p.x);
    add_exactly(bias_.y, rounding_.y, inverse * difference * p.y);
    add_exactly(bias_.z, rounding_.z, inverse * difference * p.z);
    bias_ = {std::clamp(bias_.x, -most, most), std::clamp(bias_.y, -most, most),
             std::clamp(bias_.z, -most, most)};
    heading_ = std::max(heading_ - gain * dot(row, with_heading_), Real{0});
    with_heading_ = with_heading_ - gain * p;
    const VectorOf<Real> k = inverse * p;
    xx_ = std::max(xx_ - k.x * p.x, Real{0});
    yy_ = std::max(yy_ - k.y * p.y, Real{0});
    zz_ = std::max(zz_ - k.z * p.z, Real{0});
    xy_ -= k.x * p.y;
    xz_ -= k.x * p.z;
    yz_ -= k.y * p.z;
    return gain * difference;
  }

  SORTIE_FIELDS(bias_, rounding_, with_heading_, heading_, xx_, xy_, xz_, yy_, yz_, zz_)

 private:
  VectorOf<Real> times(const VectorOf<Real>& v) const {
    return {xx_ * v.x + xy_ * v.y + xz_ * v.z, xy_ * v.x + yy_ * v.y + yz_ * v.z,
            xz_ * v.x + yz_ * v.y + zz_ * v.z};
  }

  VectorOf<Real> bias_;
  VectorOf<Real> rounding_;      // what it took from bias_: in float small steps would be lost
  VectorOf<Real> with_heading_;  // covariance of the heading's error with the bias's
  Real heading_{};
  Real xx_{}, xy_{}, xz_{}, yy_{}, yz_{}, zz_{};
};

}  // namespace sortie::estimators
