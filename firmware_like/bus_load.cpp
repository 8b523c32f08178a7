// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bus_load.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>
#include <ostream>
#include <stdexcept>

#include "drivers/can_timing.hpp"
#include "firmware_like/text_format.hpp"

namespace sortie::firmware {
namespace {

constexpr std::size_t kMostFrames = 64;

double in_us(rt::Nanoseconds ns) { return static_cast<double>(ns) * 1e-3; }

std::string identifier(const drivers::CanStream& stream) {
  char text[16];
  std::snprintf(text, sizeof text, stream.extended ? "%08X" : "%03X", static_cast<unsigned>(stream.id));
  return text;
}

void read_others(Profile& profile, std::vector<drivers::CanStream>& streams) {
  using Kind = ColumnSpec::Kind;
  const std::vector<ColumnSpec> columns{
      {"name", Kind::text, {}, true},
      {"id", Kind::number, {0, 0, 0x1FFFFFFF, "", ""}, true},
      {"extended", Kind::flag, {}, false},
      {"size", Kind::number, {8, 0, 8, "", ""}, false},
      {"period_ms", Kind::number, {0, 0.1, 1e6, "ms", ""}, true},
      {"jitter_ms", Kind::number, {0, 0, 1e4, "ms", ""}, false},
  };
  for (const ProfileRow& row :
       profile.rows("can.frames", columns, kMostFrames, "frames of other devices on the bus, for its load")) {
    const auto ns = [&](const char* name) {
      return static_cast<rt::Nanoseconds>(1e6 * row.numbers.at(name));
    };
    drivers::CanStream stream;
    stream.name = row.texts.at("name");
    stream.id = static_cast<std::uint32_t>(row.numbers.at("id"));
    stream.extended = row.numbers.at("extended") != 0;
    stream.size = static_cast<std::uint8_t>(row.numbers.at("size"));
    stream.period_ns = ns("period_ms");
    stream.jitter_ns = ns("jitter_ms");
    streams.push_back(stream);
  }
}

// Indices of the streams, the most urgent first.
std::vector<std::size_t> by_urgency(const std::vector<drivers::CanStream>& streams) {
  const auto key = [&](std::size_t i) {
    drivers::CanFrame frame;
    frame.id = streams[i].id;
    frame.flags = static_cast<std::uint8_t>(streams[i].extended ? drivers::kCanExtended : 0);
    return drivers::can_arbitration_key(frame);
  };
  std::vector<std::size_t> order(streams.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return order;
}

}  // namespace

BusLoad check_bus(Profile& profile, std::vector<drivers::CanStream> streams) {
  BusLoad bus;
  bus.bitrate = static_cast<std::uint32_t>(
      profile.integer("can.bitrate", {500'000, 10'000, 1'000'000, "bit/s", "of the CAN bus, for its load"}));
  bus.max_share =
      0.01 * profile.number("can.max_load_percent",
                            {80, 1, 100, "%", "a scene whose frames may fill the bus further is refused"});
  read_others(profile, streams);
  bus.streams = std::move(streams);
  try {
    bus.load = drivers::can_load(bus.bitrate, bus.streams);
  } catch (const std::runtime_error& error) {
    profile.fail("can.bitrate", error.what());
  }
  if (bus.load.share > bus.max_share) {
    profile.fail(
        "can.max_load_percent",
        "the frames of this scene can fill " + format_fixed(100 * bus.load.share, 1) +
            " % of the bus, above the allowed " + format_fixed(100 * bus.max_share, 1) +
            " %; a higher can.bitrate, lower rates, or a second bus help (sortie scenes shows each frame)");
  }
  for (const std::size_t i : by_urgency(bus.streams)) {
    const drivers::CanStreamLoad& load = bus.load.streams[i];
    if (load.worst_ns >= 0 && load.worst_ns <= bus.streams[i].period_ns + bus.streams[i].jitter_ns) continue;
    profile.fail("can.bitrate", "frame " + bus.streams[i].name + " (" + identifier(bus.streams[i]) +
                                    ") comes every " + format_short(in_us(bus.streams[i].period_ns)) +
                                    " us and may take " +
                                    (load.worst_ns < 0 ? std::string("longer than that")
                                                       : format_short(in_us(load.worst_ns)) + " us") +
                                    " to get through; a higher can.bitrate or lower rates help");
  }
  return bus;
}

void print_bus(std::ostream& out, const BusLoad& bus) {
  if (bus.streams.empty()) return;
  out << pad_right("CAN frame [us]", 18);
  for (const char* head : {"id", "bytes", "period", "on bus", "load", "worst"}) out << pad_left(head, 10);
  out << '\n';
  for (const std::size_t i : by_urgency(bus.streams)) {
    const drivers::CanStream& stream = bus.streams[i];
    const drivers::CanStreamLoad& load = bus.load.streams[i];
    out << pad_right(shorten(stream.name, 18), 18) << pad_left(identifier(stream), 10)
        << pad_left(std::to_string(stream.size), 10) << pad_left(format_short(in_us(stream.period_ns)), 10)
        << pad_left(format_short(in_us(load.bus_ns)), 10)
        << pad_left(format_fixed(100 * load.share, 2) + " %", 10)
        << pad_left(format_short(in_us(load.worst_ns)), 10) << '\n';
  }
  out << pad_right("bus", 18) << "  " << bus.bitrate << " bit/s, at worst "
      << format_fixed(100 * bus.load.share, 1) << " % full, " << format_fixed(100 * bus.max_share, 1)
      << " % allowed\n";
}

nlohmann::ordered_json to_json(const BusLoad& bus) {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (const std::size_t i : by_urgency(bus.streams)) {
    const drivers::CanStream& stream = bus.streams[i];
    const drivers::CanStreamLoad& load = bus.load.streams[i];
    frames.push_back({{"name", stream.name},
                      {"id", stream.id},
                      {"extended", stream.extended},
                      {"size", stream.size},
                      {"period_us", in_us(stream.period_ns)},
                      {"bus_us", in_us(load.bus_ns)},
                      {"share", load.share},
                      {"worst_us", in_us(load.worst_ns)}});
  }
  return {
      {"bitrate", bus.bitrate}, {"share", bus.load.share}, {"max_share", bus.max_share}, {"frames", frames}};
}

}  // namespace sortie::firmware
