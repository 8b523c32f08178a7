// SPDX-License-Identifier: BSD-3-Clause
// The driver (a gas sensor on the CAN bus) and what the task does (mean and alarm). Plain: no clock, no heap.
#pragma once

#include "drivers/can_bus.hpp"
#include "rt/describe.hpp"

/// One reading. Its fields are all that log, replay and export need to know.
struct GasSample {
  sortie::rt::Nanoseconds stamp_ns{};
  double gas_ppm{};
  SORTIE_FIELDS(stamp_ns, gas_ppm)
};

/// Driver. Frame 0x150, two bytes: gas in ppm. Status: ok, or not_supported (a frame of another device).
inline sortie::Status decode(const sortie::drivers::CanFrame& frame, GasSample& sample) {
  if (frame.id != 0x150 || frame.size != 2 || frame.flags != 0) return sortie::Status::not_supported;
  sample = {frame.stamp_ns, static_cast<double>(frame.data[0] + 256 * frame.data[1])};
  return sortie::Status::ok;
}

/// Output of the task. The alarm is on above `alarm_ppm` and off below half of it.
struct GasState {
  sortie::rt::Nanoseconds stamp_ns{};
  double mean_ppm{};
  bool alarm{};
  std::uint32_t rejected{};
  SORTIE_FIELDS(stamp_ns, mean_ppm, alarm, rejected)

  void update(const GasSample& sample, double alarm_ppm) {
    const double dt_s = sortie::rt::to_seconds(sample.stamp_ns - stamp_ns);
    if (!(dt_s > 0)) return void(++rejected);
    mean_ppm += (sample.gas_ppm - mean_ppm) * dt_s / (dt_s + 0.1);  // time constant 0.1 s
    alarm = mean_ppm > (alarm ? 0.5 : 1.0) * alarm_ppm;
    stamp_ns = sample.stamp_ns;
  }
};
