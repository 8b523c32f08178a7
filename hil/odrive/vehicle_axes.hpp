// SPDX-License-Identifier: BSD-3-Clause
// The simulated ground vehicle's motors on ODrives, on one connector: two belts, four flippers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hil/motor_wishes.hpp"
#include "hil/odrive/axis_node.hpp"

namespace sortie::hil {

/// Their numbers, and what a turn is worth.
struct VehicleAxesConfig {
  bool enabled{};
  std::array<std::uint8_t, 2> track_nodes{1, 2};
  std::array<std::uint8_t, rt::kFlippers> flipper_nodes{11, 12, 13, 14};
  double turns_per_m{20.0};
  double turns_per_rad{16.0};
  double torque_per_a_n_m{1.0};
  rt::Nanoseconds watchdog_ns{100 * rt::kNanosecondsPerMillisecond};  ///< 0: somebody forgot it
};

/// All of them. A body without flippers has no axes for them. Flippers have absolute encoders.
class VehicleAxes {
 public:
  /// Throws std::runtime_error for numbers that a bus does not have.
  VehicleAxes(const VehicleAxesConfig& config, drivers::CanBus& port, bool flippers);

  /// Before the frames of a step: what the motors show.
  void show(const VehicleBody& body, rt::Nanoseconds now_ns) noexcept;
  void hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  /// After them: heartbeats and estimates go out, and the body is told what its motors are to do.
  void step(VehicleBody& body, rt::Nanoseconds now_ns) noexcept;

  std::size_t size() const { return nodes_.size(); }
  AxisNode& node(std::size_t i) { return nodes_[i]; }
  const AxisNode& node(std::size_t i) const { return nodes_[i]; }

 private:
  VehicleAxesConfig config_;
  std::vector<AxisNode> nodes_;
  std::array<double, 2 + rt::kFlippers> shown_turns_{};
  rt::Nanoseconds shown_ns_{-1};
};

}  // namespace sortie::hil
