// SPDX-License-Identifier: BSD-3-Clause
// The attitude filter in the precision that the profile asks for.
#pragma once

#include <variant>

#include "estimators/attitude.hpp"

namespace sortie::firmware {

/// A filter in double precision, or in single: half of the state, and on a processor without double precision
/// a small part of the time; the same within 0.01 degrees.
class ChosenAttitude {
  using Double = estimators::Attitude;
  using Single = estimators::AttitudeFloat;

 public:
  ChosenAttitude(const estimators::AttitudeConfig& config, bool in_single) : filter_(Double(config)) {
    if (in_single) filter_.emplace<Single>(config);
  }

  /// Gives what `use` makes of the filter, an estimators::BasicAttitude that stays where it is. Costs a
  /// branch; not std::visit, which may throw.
  template <class Use>
  auto with(Use use) {
    if (Single* single = std::get_if<Single>(&filter_)) return use(*single);
    return use(*std::get_if<Double>(&filter_));
  }
  template <class Use>
  auto with(Use use) const {
    if (const Single* single = std::get_if<Single>(&filter_)) return use(*single);
    return use(*std::get_if<Double>(&filter_));
  }

 private:
  std::variant<Double, Single> filter_;
};

}  // namespace sortie::firmware
