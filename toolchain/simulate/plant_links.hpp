// SPDX-License-Identifier: BSD-3-Clause
// The ways from a simulated robot to a runtime in another process.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "drivers/can_datagram.hpp"
#include "drivers/can_socket.hpp"
#include "drivers/scan_datagram.hpp"
#include "drivers/ssl_datagram.hpp"
#include "firmware_like/live/simulated_robot.hpp"

namespace sortie::toolchain {

/// The robot's bus, its lidar, and its solid-state lidar where it has one.
class PlantLinks {
 public:
  /// Opens them: the bus as datagrams to `port`, or on a SocketCAN interface where one is named; the next
  /// ports are the lidars'. `zero_ns`: when the devices' clock read 0. Robot and scans outlive it.
  /// Precondition: the robot has a bus. Throws ProfileError.
  PlantLinks(std::uint16_t port, const std::string& can_interface, rt::Nanoseconds zero_ns,
             firmware::SimulatedRobot& robot, drivers::ScanSender& scans);

  /// Hands the robot what the runtime asks of it. About every millisecond.
  void bring();
  /// Sends the runtime what the robot tells.
  void take();
  /// The link by which a runtime is heard.
  const drivers::DatagramLink& judged() const { return by_datagram_ ? datagrams_.link() : scans_.link(); }
  void add_counters(std::map<std::string, std::uint64_t>& counters) const;

 private:
  bool by_datagram_;
  drivers::CanDatagram datagrams_;
  drivers::SocketCan interface_;
  drivers::CanBus& inside_;
  drivers::CanBus& outside_;
  drivers::ScanSender& scans_;
  drivers::SslPort* solid_state_;
  drivers::SslDatagramDevice rays_;
};

}  // namespace sortie::toolchain
