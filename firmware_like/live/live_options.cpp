// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live/live_options.hpp"

#include <iostream>

#include "drivers/lcm_url.hpp"

namespace sortie::firmware {

void add_live_options(Command& command, LiveRunOptions& options) {
  options.lcm_url = std::string(drivers::kDefaultLcmUrl);
  command.add_option("--scene", options.scene, "Scene by name, or a .toml file")->required();
  command.add_option("--set", options.overrides, "Override a key of the profile: key=value")->take_all();
  command.add_option("--map", options.maps.map, "Begin with this map of surfaces, of `export surfels`")
      ->type_name("FILE");
  command
      .add_option("--targets", options.maps.targets, "Recognise what these targets are, of `export targets`")
      ->type_name("FILE");
  command.add_option("--images", options.maps.images, "Recognise what these images show, of `export images`")
      ->type_name("FILE");
  command.add_option("--seconds", options.seconds, "How long")->in_range(0.01, 1e7)->capture_default_str();
  command.add_flag("--virtual", options.virtual_time,
                   "Simulated time, as fast as it goes; the same outputs every time");
  command.add_option("--record", options.record, "Write an LCM log that replays to the same digest")
      ->type_name("LOG");
  command.add_flag("--record-fields", options.record_fields,
                   "Put all outputs into the log, so that `check` can name a field");
  command.add_option("--lcm-url", options.lcm_url, "Where telemetry goes; none: off")->capture_default_str();
  command.add_option("--can", options.can_interface, "Real CAN interface instead of the simulated robot")
      ->type_name("IFACE");
  command
      .add_option("--plant", options.plant,
                  "own, or own:PORT: against `sortie plant` in another process instead; with --can over CAN")
      ->type_name("WHERE");
  command.add_flag("--require-rt", options.require_realtime,
                   "Exit 4 when the platform refuses real-time scheduling");
  command.add_flag("!--no-rt", options.realtime, "Do not ask for real-time scheduling");
  command
      .add_option("--flight-ring", options.flight_ring.path,
                  "Keep the last ticks in FILE, where a crash cannot take them; auto: in memory, none: not")
      ->type_name("FILE")
      ->capture_default_str();
  command.add_option("--flight-ticks", options.flight_ring.ticks, "How many ticks the flight ring keeps")
      ->in_range(16, 10'000'000)
      ->capture_default_str();
}

void tell_files(const LiveRunOutcome& outcome) {
  if (!outcome.flight_ring.empty()) std::cerr << "flight ring: " << outcome.flight_ring << "\n";
  if (!outcome.log.empty()) std::cerr << "log: " << outcome.log << "\n";
  if (!outcome.former_log.empty()) std::cerr << "the former log: " << outcome.former_log << "\n";
}

}  // namespace sortie::firmware
