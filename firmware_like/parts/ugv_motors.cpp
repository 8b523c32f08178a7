// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_motors.hpp"

#include <algorithm>
#include <string>

namespace sortie::firmware {
namespace {

// Counters of all members together: which one it was is on the bus, and in the log. `at(i)`: the i-th one's.
template <class Counters, class At>
void add_sums(VehicleBuilder& builder, const std::string& prefix, std::size_t members, At at) {
  std::size_t field = 0;
  Counters::fields(at(0), [&](const char* name, const std::uint64_t&) {
    builder.counter(prefix + name, [members, at, which = field++] {
      std::uint64_t sum = 0;
      for (std::size_t i = 0; i < members; ++i) {
        std::size_t k = 0;
        Counters::fields(at(i),
                         [&](const char*, const std::uint64_t& count) { sum += k++ == which ? count : 0; });
      }
      return sum;
    });
  });
}

void add_state(VehicleBuilder& builder, const std::string& prefix, const drivers::UgvDrives& motors) {
  const drivers::UgvDrives* const all = &motors;
  builder.counter(prefix + "running", [all] { return std::uint64_t{all->running() ? 1u : 0u}; });
  builder.counter(prefix + "stop_reason", [all] { return static_cast<std::uint64_t>(all->stop_reason()); });
  builder.counter(prefix + "stops", [all] { return all->group().stops(); });
  builder.counter(prefix + "starts", [all] { return all->group().starts(); });
}

}  // namespace

MotorsConfig read_motors(Profile& profile, bool flippers) {
  const std::string protocol =
      profile.text("drives.protocol", "own", "what the drives speak", {"own", "canopen", "odrive"});
  MotorsConfig config;
  if (protocol == "own") return config;
  const auto read = [&](auto& drives) {
    drives.flippers = flippers;
    profile.read("drives", drives);
  };
  if (protocol == "canopen") {
    read(config.canopen.emplace());
  } else {
    read(config.odrive.emplace());
  }
  return config;
}

std::unique_ptr<drivers::UgvDrives> make_canopen(VehicleBuilder& builder,
                                                 const drivers::canopen::UgvNodesConfig& config) {
  auto drives = std::make_unique<drivers::canopen::UgvNodes>(config);
  const drivers::canopen::NodeLine* const line = &drives->line();
  builder.bus_frames(drivers::canopen::bus_frames(config));
  builder.counters("canopen_", line->counters());
  add_sums<drivers::canopen::DriveCounters>(
      builder, "canopen_drives_",
      line->size(), [line](std::size_t i) -> const auto& { return line->drive(i).counters(); });
  add_state(builder, "canopen_", *drives);
  return drives;
}

std::unique_ptr<drivers::UgvDrives> make_odrive(VehicleBuilder& builder,
                                                const drivers::odrive::UgvAxesConfig& config) {
  auto axes = std::make_unique<drivers::odrive::UgvAxes>(config);
  const drivers::odrive::AxisLine* const line = &axes->line();
  builder.bus_frames(drivers::odrive::bus_frames(config));
  builder.counters("odrive_", line->counters());
  add_sums<drivers::odrive::AxisCounters>(
      builder, "odrive_axes_",
      line->size(), [line](std::size_t i) -> const auto& { return line->axis(i).counters(); });
  builder.counter("odrive_watchdog_us", [line] {
    rt::Nanoseconds worst_ns = 0;
    for (std::size_t i = 0; i < line->size(); ++i) worst_ns = std::max(worst_ns, line->axis(i).watchdog_ns());
    return static_cast<std::uint64_t>(worst_ns / 1000);
  });
  add_state(builder, "odrive_", *axes);
  return axes;
}

}  // namespace sortie::firmware
