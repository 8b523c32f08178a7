// SPDX-License-Identifier: BSD-3-Clause
// What a person does to a simulated robot's motors at given times: an emergency stop's button on the bus, and
// the switch of the drives' power.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "drivers/can_bus.hpp"
#include "rt/time.hpp"

namespace sortie::hil {

/// One deed, at a time since the start.
struct StopDeed {
  enum class What : std::uint8_t { press, release, power_off, power_on };
  rt::Nanoseconds at_ns{};
  What what{What::press};
};

/// Plays them. No heap after construction.
class StopScript {
 public:
  static constexpr rt::Nanoseconds kButtonEvery = 50 * rt::kNanosecondsPerMillisecond;

  /// In order of time. Without any there is no button either.
  explicit StopScript(std::vector<StopDeed> deeds) : deeds_(std::move(deeds)) {}

  /// One moment: what is due is done, and the button says how it is.
  void step(rt::Nanoseconds since_start_ns, drivers::CanBus& port);
  bool powered() const { return powered_; }

 private:
  std::vector<StopDeed> deeds_;
  std::size_t next_{};
  bool pressed_{};
  bool powered_{true};
  std::uint8_t counter_{};
  rt::Nanoseconds next_frame_ns_{};
};

}  // namespace sortie::hil
