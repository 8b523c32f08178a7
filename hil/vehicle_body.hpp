// SPDX-License-Identifier: BSD-3-Clause
// What a simulated ground vehicle is moved by: commands in, exact state out. The sensors and the bus around
// it do not know how it moves.
#pragma once

#include <cstdint>

#include "drivers/can_flippers.hpp"
#include "hil/motion.hpp"
#include "rt/contact_truth.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::hil {

/// Counts of a vehicle's life.
struct RobotCounters {
  std::uint64_t commands{};          ///< taken
  std::uint64_t stale_steps{};       ///< steps with an outdated command
  std::uint64_t obstructed_steps{};  ///< steps in which something held the body while the belts ran
};

/// A vehicle's body. One thread at a time.
class VehicleBody {
 public:
  virtual ~VehicleBody() = default;

  /// A new command for the belts, received at `now_ns`. Status: ok, not_finite (the last one ages).
  virtual Status set_command(const rt::DriveCommand& command, rt::Nanoseconds now_ns) = 0;
  /// Which belts have no torque until the next call: they coast.
  virtual void let_go(bool /*left*/, bool /*right*/) {}
  /// A new command for a pair of flippers. Status: ok, not_finite, not_supported (there are none).
  virtual Status set_flippers(const drivers::FlipperPairCommand& /*command*/) {
    return Status::not_supported;
  }
  /// Advances by the step that it was made with.
  virtual void step() = 0;

  /// Exact state now.
  virtual const Motion& motion() const = 0;
  /// Angles and torques of the flippers now. False where there are none.
  virtual bool read_flippers(rt::FlipperSample& /*sample*/) const { return false; }
  /// Contacts of the last step, and the flippers, exact. False where there are no contacts.
  virtual bool read_contacts(rt::ContactTruth& /*truth*/) const { return false; }
  virtual RobotCounters counters() const = 0;
};

}  // namespace sortie::hil
