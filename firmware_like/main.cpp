// SPDX-License-Identifier: BSD-3-Clause
// The program that a robot carries, built for one scene, with a heap trap that watches the tasks.
#include "firmware_like/command_program.hpp"
#include "firmware_like/robot_commands.hpp"
#include "firmware_like/robots/registry.hpp"
#include "firmware_like/runtime/heap_watch.hpp"

int main(int argc, char** argv) {
  namespace firmware = sortie::firmware;
  firmware::watch_heap();
  const firmware::VehicleRegistry vehicles = firmware::own_vehicles();
  return firmware::run_commands(argc, argv, "sortie",
                                [&vehicles](firmware::Command& root, std::function<int()>& chosen) {
                                  firmware::add_robot_commands(root, vehicles, chosen);
                                });
}
