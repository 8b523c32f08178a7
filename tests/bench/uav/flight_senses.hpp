// SPDX-License-Identifier: BSD-3-Clause
// What a pilot is told about the vehicle: the truth with noise and delay, or an estimate from sensors.
#pragma once

#include <deque>
#include <memory>

#include "estimators/uav_state/disturbance_observer.hpp"
#include "hil/random.hpp"
#include "tests/bench/uav/flight.hpp"

namespace sortie::bench {

class FlightSenses {
 public:
  explicit FlightSenses(const FlightSetup& setup);
  ~FlightSenses();
  FlightSenses(const FlightSenses&) = delete;
  FlightSenses& operator=(const FlightSenses&) = delete;

  /// What the rotors are expected to make from now on, as a collective acceleration.
  void expect(double thrust_m_s2) { expected_m_s2_ = thrust_m_s2; }
  /// After each plant step.
  void observe(hil::MultirotorPlant& plant);
  /// At the start of a period; `expected_m_s2` is the mean collective acceleration over the last one.
  rt::UavState state(hil::MultirotorPlant& plant, double now_s, double expected_m_s2);
  double estimate_rms_m() const;
  /// Least of five runs over all that the estimator was given: its run time, us per second of flight.
  double estimate_cost_us_s() const;

 private:
  rt::UavState true_state(hil::MultirotorPlant& plant, double now_s, double expected_m_s2);
  struct Estimated;
  void stand(const hil::MultirotorPlant& plant);

  const FlightSetup& setup_;
  hil::Random random_;
  estimators::DisturbanceObserver observer_;
  std::deque<hil::Vec3> late_;
  rt::Quaternion last_q_;
  bool started_{};
  double expected_m_s2_{9.81};
  std::unique_ptr<Estimated> estimated_;
};

}  // namespace sortie::bench
