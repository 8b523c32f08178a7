// SPDX-License-Identifier: BSD-3-Clause
// How height, pitch and roll of a simulated robot follow the ground: critically damped, so that rates and
// accelerations are finite where the ground has an edge.
#pragma once

#include "rt/math.hpp"

namespace sortie::hil {

/// x'' + 2 w x' + w^2 (x - target) = 0, solved exactly for a target that is constant within a step. 40 bytes.
class Suspension {
 public:
  /// `frequency_hz` > 0 is w / (2 pi); `step_s` > 0.
  Suspension(double frequency_hz, double step_s)
      : w_(6.283185307179586 * frequency_hz), step_s_(step_s), decay_(rt::exp(-w_ * step_s)) {}

  /// Sets the state at rest.
  void reset(double value) {
    value_ = value;
    rate_ = 0.0;
  }

  /// Advances by one step. Cost: ten operations.
  void advance(double target) {
    const double error = value_ - target;
    const double mix = rate_ + w_ * error;
    value_ = target + (error + mix * step_s_) * decay_;
    rate_ = (rate_ - w_ * mix * step_s_) * decay_;
  }

  double value() const { return value_; }
  /// Change per second.
  double rate() const { return rate_; }

 private:
  double w_;
  double step_s_;
  double decay_;
  double value_{};
  double rate_{};
};

}  // namespace sortie::hil
