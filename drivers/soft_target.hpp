// SPDX-License-Identifier: BSD-3-Clause
// A target that begins where the motor is, and then goes to what is asked for at a limited rate, until it has
// caught up.
#pragma once

#include <algorithm>

namespace sortie::drivers {

/// 16 bytes, plain.
class SoftTarget {
 public:
  /// From here, at the next call of next().
  void begin(double at) noexcept {
    value_ = at;
    joins_ = true;
  }
  /// The target now; `most`: how far it may go in this step, until it has caught up.
  double next(double wish, double most) noexcept {
    if (!joins_) return wish;
    value_ += std::clamp(wish - value_, -most, most);
    joins_ = value_ != wish;
    return value_;
  }

 private:
  double value_{};
  bool joins_{true};
};

}  // namespace sortie::drivers
