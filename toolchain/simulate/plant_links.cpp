// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/simulate/plant_links.hpp"

#include "firmware_like/link/secret.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/profile.hpp"

namespace sortie::toolchain {

namespace {

constexpr int kMostFramesPerStep = 256;

// The bus that the runtime is on, and the simulated one that the plant is on, are one bus.
void carry_frames(drivers::CanBus& from, drivers::CanBus& to) {
  drivers::CanFrame frame;
  for (int i = 0; i < kMostFramesPerStep && from.receive(frame) == Status::ok; ++i) {
    frame.stamp_ns = 0;                 // of the other clock; on the bus at once
    static_cast<void>(to.send(frame));  // refusals are counted by both
  }
}

drivers::DatagramLinkConfig listening(int port) {
  drivers::DatagramLinkConfig config;
  config.port = static_cast<std::uint16_t>(port);
  config.listens = true;
  config.session = static_cast<std::uint64_t>(firmware::unguessable_number());
  return config;
}

void require(Status status, const std::string& option, const std::string& problem) {
  if (status != Status::ok) throw firmware::ProfileError(option + ": " + problem);
}

}  // namespace

PlantLinks::PlantLinks(std::uint16_t port, const std::string& can_interface, rt::Nanoseconds zero_ns,
                       firmware::SimulatedRobot& robot, drivers::ScanSender& scans)
    : by_datagram_(can_interface.empty()),
      inside_(*robot.vehicle_can()),
      outside_(by_datagram_ ? static_cast<drivers::CanBus&>(datagrams_) : interface_),
      scans_(scans),
      solid_state_(robot.vehicle_ssl()) {
  std::string problem;
  const std::string option = "--port " + std::to_string(port);
  if (by_datagram_) {
    require(datagrams_.open(listening(port), zero_ns, problem), option, problem);
  } else {
    drivers::SocketCanConfig config;
    config.interface = can_interface;
    config.epoch_ns = zero_ns;
    require(interface_.open(config, problem), "--can " + can_interface, problem);
  }
  require(scans_.open(listening(port + 1), zero_ns, problem),
          option + ", lidar on " + std::to_string(port + 1), problem);
  if (solid_state_ != nullptr)
    require(rays_.open(listening(port + 2), zero_ns, problem),
            option + ", solid-state lidar on " + std::to_string(port + 2), problem);
}

void PlantLinks::bring() {
  carry_frames(outside_, inside_);
  if (solid_state_ != nullptr) rays_.deliver(*solid_state_);
}

void PlantLinks::take() {
  carry_frames(inside_, outside_);
  scans_.poll();
  if (solid_state_ != nullptr) rays_.collect(*solid_state_);
}

void PlantLinks::add_counters(std::map<std::string, std::uint64_t>& counters) const {
  if (by_datagram_) {
    firmware::add_counters("can_", datagrams_.link().counters(), counters);
    firmware::add_counters("can_", datagrams_.datagram_counters(), counters);
  }
  firmware::add_counters("lidar_", scans_.link().counters(), counters);
  firmware::add_counters("scan_", scans_.counters(), counters);
  if (solid_state_ == nullptr) return;
  firmware::add_counters("ssl_", rays_.link().counters(), counters);
  firmware::add_counters("rays_", rays_.counters(), counters);
}

}  // namespace sortie::toolchain
