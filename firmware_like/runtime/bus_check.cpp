// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/bus_check.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <ostream>
#include <stdexcept>

#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {
namespace {

std::string percent_of(double share) { return format_fixed(100.0 * share, 1) + " %"; }

std::vector<std::size_t> by_urgency(const BusCheck& bus) {
  std::vector<std::size_t> order(bus.frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return bus.frames[a].id < bus.frames[b].id; });
  return order;
}

}  // namespace

BusCheck check_bus(Profile& profile, const std::vector<drivers::CanStream>& frames,
                   std::vector<std::string>& warnings) {
  BusCheck bus;
  if (frames.empty()) return bus;
  bus.bitrate = static_cast<std::uint32_t>(profile.integer(
      "can.bitrate",
      {500'000, 10'000, 1e6, "bit/s", "of the CAN bus: its load is worked out before anything runs"}));
  bus.frames = frames;
  try {
    bus.load = drivers::can_load(bus.bitrate, bus.frames);
  } catch (const std::runtime_error& error) {
    profile.fail("can.bitrate", error.what());
  }
  if (bus.load.share > 1.0) {
    profile.fail("can.bitrate", "the bus would be " + percent_of(bus.load.share) + " full at " +
                                    std::to_string(bus.bitrate) +
                                    " bit/s; raise it, or send less often (rates of [can], drives.sync_ms)");
  }
  std::size_t late = 0;
  std::string first;
  for (const std::size_t i : by_urgency(bus)) {
    if (bus.load.streams[i].worst_ns >= 0) continue;
    if (late++ == 0) first = bus.frames[i].name;
  }
  if (late > 0) {
    warnings.push_back("the CAN bus may be " + percent_of(bus.load.share) + " full: " + std::to_string(late) +
                       " frames may still wait when the next of their kind is due, the first is " + first);
  }
  return bus;
}

void print_bus(std::ostream& out, const BusCheck& bus) {
  if (bus.frames.empty()) return;
  char line[128];
  std::snprintf(line, sizeof line, "%-26s %8s %6s %10s %8s %10s\n", "CAN [us]", "id", "bytes", "period",
                "load", "response");
  out << line;
  for (const std::size_t i : by_urgency(bus)) {
    const drivers::CanStream& frame = bus.frames[i];
    const drivers::CanStreamLoad& load = bus.load.streams[i];
    const std::string worst = load.worst_ns < 0 ? "no bound" : std::to_string(load.worst_ns / 1000);
    std::snprintf(line, sizeof line, "%-26.40s %#8x %6d %10lld %8s %10s\n", frame.name.c_str(), frame.id,
                  frame.size, static_cast<long long>(frame.period_ns / 1000), percent_of(load.share).c_str(),
                  worst.c_str());
    out << line;
  }
  std::snprintf(line, sizeof line, "%-26s %s of %u bit/s at worst\n", "bus",
                percent_of(bus.load.share).c_str(), bus.bitrate);
  out << line;
}

Json to_json(const BusCheck& bus) {
  Json frames = Json::array();
  for (std::size_t i = 0; i < bus.frames.size(); ++i) {
    const drivers::CanStreamLoad& load = bus.load.streams[i];
    frames.push_back({{"name", bus.frames[i].name},
                      {"id", bus.frames[i].id},
                      {"bytes", bus.frames[i].size},
                      {"period_us", static_cast<double>(bus.frames[i].period_ns) * 1e-3},
                      {"share", load.share},
                      {"response_us", nullptr}});
    if (load.worst_ns >= 0) frames.back()["response_us"] = static_cast<double>(load.worst_ns) * 1e-3;
  }
  return {{"bitrate", bus.bitrate}, {"share", bus.load.share}, {"frames", std::move(frames)}};
}

}  // namespace sortie::firmware
