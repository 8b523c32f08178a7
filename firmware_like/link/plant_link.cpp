// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/plant_link.hpp"

#include <charconv>

#include "firmware_like/link/secret.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {

std::uint16_t parse_plant(const std::string& text) {
  if (text == "own") return kPlantPort;
  std::uint16_t port = 0;
  if (text.rfind("own:", 0) == 0) {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + 4, end, port);
    if (error == std::errc() && stop == end && port >= 1024 && port <= kMostPlantPort) return port;
  }
  throw ProfileError("--plant " + text + ": write own, or own:PORT with a port from 1024 to " +
                     std::to_string(kMostPlantPort));
}

PlantLink::PlantLink(std::uint16_t port, const PlantLinkNeeds& needs, rt::Nanoseconds start_ns)
    : port_(port), needs_(needs) {
  drivers::DatagramLinkConfig config;
  const auto next_link = [&config, port](int above) {
    config.port = static_cast<std::uint16_t>(port + above);
    config.session = static_cast<std::uint64_t>(unguessable_number());
  };
  std::string problem;
  Status status = Status::ok;
  if (needs_.can) {
    next_link(0);
    status = can_.open(config, start_ns, problem);
  }
  if (status == Status::ok && needs_.scans != nullptr) {
    next_link(1);
    status = scans_.open(config, start_ns, *needs.scans, problem);
  }
  if (status == Status::ok && needs_.ssl) {
    next_link(2);
    status = ssl_.open(config, start_ns, problem);
  }
  if (status != Status::ok) throw ProfileError("--plant own: " + problem);
}

void PlantLink::poll(rt::Nanoseconds now_ns) {
  if (needs_.scans != nullptr) scans_.poll();
  if (needs_.ssl) ssl_.poll();
  const bool heard = judged().has_peer();
  if (heard == heard_) return;
  heard_ = heard;
  if (!heard) silences_.fetch_add(1, std::memory_order_relaxed);
  changed_ns_.store(now_ns, std::memory_order_relaxed);
  changes_.fetch_add(1, std::memory_order_release);
}

std::string PlantLink::news() {
  const std::uint32_t changes = changes_.load(std::memory_order_acquire);
  if (changes == told_) return {};
  told_ = changes;
  const double at_s = static_cast<double>(changed_ns_.load(std::memory_order_relaxed)) * 1e-9;
  return (changes % 2 == 1 ? "the plant is heard at " : "the plant has gone silent at ") +
         format_fixed(at_s, 1) + " s";
}

void PlantLink::add_counters(std::map<std::string, std::uint64_t>& counters) const {
  if (needs_.can) {
    firmware::add_counters("plant_can_", can_.link().counters(), counters);
    firmware::add_counters("plant_can_", can_.datagram_counters(), counters);
  }
  if (needs_.scans != nullptr) {
    firmware::add_counters("plant_lidar_", scans_.link().counters(), counters);
    firmware::add_counters("plant_scans_", scans_.counters(), counters);
  }
  if (needs_.ssl) {
    firmware::add_counters("plant_ssl_", ssl_.link().counters(), counters);
    firmware::add_counters("plant_rays_", ssl_.counters(), counters);
  }
}

std::vector<std::string> PlantLink::warnings() const {
  std::vector<std::string> warnings;
  const drivers::DatagramLinkCounters& link = judged().counters();
  const std::uint64_t silences = silences_.load(std::memory_order_relaxed);
  if (link.peers == 0)
    warnings.push_back("no plant was heard on port " + std::to_string(port_) +
                       " of 127.0.0.1; start one: sortie plant --scene SCENE --port " +
                       std::to_string(port_));
  if (silences != 0)
    warnings.push_back("the plant went silent " + std::to_string(silences) + " times" +
                       (changes_.load() % 2 == 1 ? ", and came back" : ", the last time for good"));
  if (link.peers > 1)
    warnings.push_back("the plant was restarted " + std::to_string(link.peers - 1) +
                       " times: the robot stands where it began again, and the odometry does not know");
  if (needs_.ssl && link.peers != 0 && ssl_.link().counters().peers == 0)
    warnings.push_back(
        "the plant has no solid-state lidar, or another program holds its port: no ray was fired");
  if (link.lost != 0) warnings.push_back(std::to_string(link.lost) + " datagrams of the plant were lost");
  return warnings;
}

}  // namespace sortie::firmware
