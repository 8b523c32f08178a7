// SPDX-License-Identifier: BSD-3-Clause
// Something that a run can be driven against instead of hardware: it has devices, and it knows the truth.
#pragma once

#include <string>

#include "firmware_like/runtime/factories.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "rt/contact_truth.hpp"
#include "rt/sensor_truth.hpp"

namespace sortie::firmware {

/// A simulated robot. Its step runs on one thread, the vehicle's devices may be polled from another.
class SimulatedRobot {
 public:
  virtual ~SimulatedRobot() = default;
  /// Advances the simulation to `now_ns` of the run's clock.
  virtual void step(rt::Nanoseconds now_ns) = 0;
  /// Exact pose now; flags 0 if this robot has none.
  virtual rt::TruthSample truth() const { return {}; }
  /// Contacts and flippers now; false if this robot knows of none.
  virtual bool contacts(rt::ContactTruth& /*truth*/) const { return false; }
  /// Truth of the newest IMU interval and of the belts; false if this robot knows of none.
  virtual bool sensors(rt::SensorTruth& /*truth*/) const { return false; }
  /// Least time between two records of contacts in a log; 0: they are not written.
  virtual rt::Nanoseconds contacts_every_ns() const { return 0; }
  /// Says what the clock of its devices reads at time 0 of step(), where that is not 0: in a process of its
  /// own it is CLOCK_MONOTONIC. Before the first step.
  virtual void set_device_clock(rt::Nanoseconds /*reading_ns*/) {}
  /// The node of its bus that the vehicle's drivers use, or null.
  virtual drivers::CanBus* vehicle_can() = 0;
  /// The link to its solid-state lidar, or null.
  virtual drivers::SslPort* vehicle_ssl() { return nullptr; }
  /// One line about what was built, with its seed.
  virtual std::string describe() const { return {}; }
  /// Counters for the result.
  virtual void add_counters(std::map<std::string, std::uint64_t>& /*counters*/) const {}
};

}  // namespace sortie::firmware
