// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/vehicles/canopen_config.hpp"

#include "firmware_like/vehicles/units.hpp"

namespace sortie::firmware {

std::optional<drivers::canopen::UgvDrivesConfig> read_canopen(Profile& profile, bool flippers) {
  if (profile.text("drives.protocol", "own", "what the drives speak", {"own", "canopen"}) == "own") return {};
  drivers::canopen::UgvDrivesConfig config;
  config.flippers = flippers;
  const auto node = [&](const char* path, std::uint8_t& number) {
    number = static_cast<std::uint8_t>(
        profile.integer(path, {static_cast<double>(number), 1, 127, "", "canopen: number of this node"}));
  };
  node("drives.node_master", config.master.node);
  node("drives.node_left", config.track_nodes[0]);
  node("drives.node_right", config.track_nodes[1]);
  node("drives.node_front_left", config.flipper_nodes[0]);
  node("drives.node_front_right", config.flipper_nodes[1]);
  node("drives.node_rear_left", config.flipper_nodes[2]);
  node("drives.node_rear_right", config.flipper_nodes[3]);
  config.increments_per_m = profile.number(
      "drives.increments_per_m", {config.increments_per_m, 1, 1e8, "1/m", "canopen: of a track's encoder"});
  config.increments_per_rad =
      profile.number("drives.increments_per_rad",
                     {config.increments_per_rad, 1, 1e8, "1/rad", "canopen: of a flipper's encoder"});
  config.rated_torque_n_m =
      profile.number("drives.rated_torque_n_m",
                     {config.rated_torque_n_m, 0.001, 1e6, "N m", "canopen: of a flipper, for its torque"});
  const auto ms = [&](const char* path, rt::Nanoseconds& value, double high, const char* meaning) {
    value = milliseconds(profile.number(path, {in_ms(value), 1, high, "ms", meaning}));
  };
  ms("drives.sync_ms", config.master.sync_period_ns, 255, "canopen: between commands, whole ms");
  ms("drives.heartbeat_ms", config.heartbeat_ns, 10'000,
     "canopen: of each drive and of the runtime, whole ms");
  config.master.heartbeat_ns = config.heartbeat_ns;
  ms("drives.heartbeat_timeout_ms", config.heartbeat_timeout_ns, 60'000,
     "canopen: silence after which a drive stops by itself, or counts as lost, whole ms");
  ms("drives.command_timeout_ms", config.master.command_timeout_ns, 10'000,
     "canopen: without a new command for so long all drives stop");
  config.master.rearm_ns = milliseconds(
      1e3 * profile.number("drives.rearm_s", {1, 0, 3600, "s",
                                              "canopen: after a stop the drives run again when all have been "
                                              "well for so long; 0: when the command was off in between"}));
  return config;
}

}  // namespace sortie::firmware
