// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/vehicles/ugv_motors.hpp"

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

template <class Counters>
void add_counts(VehicleBuilder& builder, const std::string& prefix, const Counters& counters) {
  Counters::fields(counters, [&](const char* name, const std::uint64_t& count) {
    builder.counter(prefix + name, [&count] { return count; });
  });
}

void add_state(VehicleBuilder& builder, const std::string& prefix, const drivers::UgvMotors& motors) {
  const drivers::UgvMotors* const all = &motors;
  builder.counter(prefix + "running", [all] { return std::uint64_t{all->running() ? 1u : 0u}; });
  builder.counter(prefix + "stop_reason", [all] { return static_cast<std::uint64_t>(all->stop_reason()); });
}

}  // namespace

std::unique_ptr<drivers::UgvMotors> make_canopen(VehicleBuilder& builder,
                                                 const drivers::canopen::UgvDrivesConfig& config) {
  auto drives = std::make_unique<drivers::canopen::UgvDrives>(config);
  const drivers::canopen::Master* const master = &drives->master();
  builder.bus_frames(drivers::canopen::bus_frames(config));
  add_counts(builder, "canopen_", master->counters());
  add_sums<drivers::canopen::DriveCounters>(
      builder, "canopen_drives_",
      master->size(), [master](std::size_t i) -> const auto& { return master->drive(i).counters(); });
  add_state(builder, "canopen_", *drives);
  return drives;
}

std::unique_ptr<drivers::UgvMotors> make_odrive(VehicleBuilder& builder,
                                                const drivers::odrive::UgvAxesConfig& config) {
  auto axes = std::make_unique<drivers::odrive::UgvAxes>(config);
  const drivers::odrive::AxisGroup* const group = &axes->group();
  builder.bus_frames(drivers::odrive::bus_frames(config));
  add_counts(builder, "odrive_", group->counters());
  add_sums<drivers::odrive::AxisCounters>(
      builder, "odrive_axes_",
      group->size(), [group](std::size_t i) -> const auto& { return group->axis(i).counters(); });
  builder.counter("odrive_watchdog_us", [group] {
    rt::Nanoseconds worst_ns = 0;
    for (std::size_t i = 0; i < group->size(); ++i)
      worst_ns = std::max(worst_ns, group->axis(i).watchdog_ns());
    return static_cast<std::uint64_t>(worst_ns / 1000);
  });
  add_state(builder, "odrive_", *axes);
  return axes;
}

}  // namespace sortie::firmware
