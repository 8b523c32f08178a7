// SPDX-License-Identifier: BSD-3-Clause
// The attitude filter in the precision that the profile asks for.
#pragma once

#include <variant>

#include "estimators/attitude.hpp"

namespace sortie::firmware {

/// A filter in double precision, or in single: half of the state, and on a processor without double precision
/// a small part of the time; the same within 0.01 degrees. Calls and promises are those of
/// estimators::BasicAttitude; each costs a branch more.
class ChosenAttitude {
  using Double = estimators::Attitude;
  using Single = estimators::AttitudeFloat;

  // Not std::visit, which may throw.
  template <class Call>
  auto call(Call&& what) {
    if (Single* single = std::get_if<Single>(&filter_)) return what(*single);
    return what(*std::get_if<Double>(&filter_));
  }

 public:
  ChosenAttitude(const estimators::AttitudeConfig& config, bool in_single) : filter_(Double(config)) {
    if (in_single) filter_.emplace<Single>(config);
  }

  Status update(const rt::ImuSample& sample) {
    return call([&](auto& filter) { return filter.update(sample); });
  }
  void set_moving(bool moving) {
    call([&](auto& filter) { filter.set_moving(moving); });
  }
  Status set_track_velocity(const rt::Vector3& v_body_m_s, rt::Nanoseconds stamp_ns) {
    return call([&](auto& filter) { return filter.set_track_velocity(v_body_m_s, stamp_ns); });
  }
  void set_acc_time_constant(double seconds) {
    call([&](auto& filter) { filter.set_acc_time_constant(seconds); });
  }
  void set_bias_forgetting(double seconds) {
    call([&](auto& filter) { filter.set_bias_forgetting(seconds); });
  }
  const rt::AttitudeEstimate& estimate() const {
    const Single* single = std::get_if<Single>(&filter_);
    return single != nullptr ? single->estimate() : std::get_if<Double>(&filter_)->estimate();
  }
  const estimators::AttitudeCounters& counters() const {
    const Single* single = std::get_if<Single>(&filter_);
    return single != nullptr ? single->counters() : std::get_if<Double>(&filter_)->counters();
  }
  /// State to bytes and back, into a filter of the same configuration and precision.
  void archive(rt::Archive& archive) {
    call([&](auto& filter) { filter.archive(archive); });
  }

 private:
  std::variant<Double, Single> filter_;
};

}  // namespace sortie::firmware
