// SPDX-License-Identifier: BSD-3-Clause
// The simulated ground vehicle's drives on CANopen, on one connector: two belts, four flippers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hil/canopen/node.hpp"
#include "hil/motor_wishes.hpp"

namespace sortie::hil {

/// Their numbers, and what an increment is worth.
struct VehicleDrivesConfig {
  bool enabled{};  ///< otherwise the drives speak the robot's own frames
  std::array<std::uint8_t, 2> track_nodes{1, 2};
  std::array<std::uint8_t, rt::kFlippers> flipper_nodes{11, 12, 13, 14};
  double increments_per_m{10'000.0};
  double increments_per_rad{10'000.0};
  double rated_torque_n_m{100.0};
};

/// All of them. A body without flippers has no flipper drives.
class VehicleDrives {
 public:
  /// Throws std::runtime_error for numbers that a bus does not have.
  VehicleDrives(const VehicleDrivesConfig& config, drivers::CanBus& port, bool flippers);

  /// Before the frames of a step: what the motors show.
  void show(const VehicleBody& body) noexcept;
  void hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  /// After them: heartbeats go out, and the body is told what its motors are to do.
  void step(VehicleBody& body, rt::Nanoseconds now_ns) noexcept;

  std::size_t size() const { return nodes_.size(); }
  CanopenNode& node(std::size_t i) { return nodes_[i]; }
  const CanopenNode& node(std::size_t i) const { return nodes_[i]; }

 private:
  VehicleDrivesConfig config_;
  std::vector<CanopenNode> nodes_;
  std::array<double, 2 + rt::kFlippers> shown_{};
};

}  // namespace sortie::hil
