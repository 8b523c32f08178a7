// SPDX-License-Identifier: BSD-3-Clause
// The runtime's end of the links to a plant in a process of its own: CAN bus, lidar, solid-state lidar.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/can_datagram.hpp"
#include "drivers/scan_datagram.hpp"
#include "drivers/ssl_datagram.hpp"

namespace sortie::firmware {

/// Port of a plant on 127.0.0.1; the one above it is its lidar's, the next its solid-state lidar's.
inline constexpr std::uint16_t kPlantPort = 7710;
inline constexpr std::uint16_t kMostPlantPort = 65535 - 2;

/// "own", or "own:PORT" for another port than kPlantPort. Throws ProfileError.
std::uint16_t parse_plant(const std::string& text);

/// What a runtime wants of a plant.
struct PlantLinkNeeds {
  bool can{};                  ///< frames come over the link, not over a SocketCAN interface
  drivers::ScanSink* scans{};  ///< null: no lidar
  bool ssl{};                  ///< a solid-state lidar
};

/// The links of a runtime. Opened at start-up; then one thread polls, and any other may ask for news.
class PlantLink {
 public:
  /// Stamps count from `start_ns` of CLOCK_MONOTONIC. Throws ProfileError.
  PlantLink(std::uint16_t port, const PlantLinkNeeds& needs, rt::Nanoseconds start_ns);

  /// The port on the plant's bus, or null when that is a SocketCAN interface.
  drivers::CanBus* can() { return needs_.can ? &can_ : nullptr; }
  /// The way to the solid-state lidar, or null.
  drivers::SslPort* ssl() { return needs_.ssl ? &ssl_ : nullptr; }
  /// Takes scans and frames of the solid-state lidar, and notes whether the plant is there. On the thread
  /// that polls devices. Real-time safe.
  void poll(rt::Nanoseconds now_ns);
  /// One line when the plant has come or gone since the last call, else empty. Any one thread.
  std::string news();

  void add_counters(std::map<std::string, std::uint64_t>& counters) const;
  /// What a user should know at the end.
  std::vector<std::string> warnings() const;

 private:
  const drivers::DatagramLink& judged() const {
    return needs_.can ? can_.link() : needs_.scans != nullptr || !needs_.ssl ? scans_.link() : ssl_.link();
  }

  std::uint16_t port_;
  PlantLinkNeeds needs_;
  drivers::CanDatagram can_;
  drivers::ScanReceiver scans_;
  drivers::SslDatagram ssl_;
  bool heard_{};                             ///< of the polling thread
  std::atomic<std::int64_t> changed_ns_{0};  ///< run's clock
  std::atomic<std::uint32_t> changes_{0};    ///< odd: the plant is there
  std::atomic<std::uint64_t> silences_{0};
  std::uint32_t told_{};  ///< of the asking thread
};

}  // namespace sortie::firmware
