// SPDX-License-Identifier: BSD-3-Clause
// The program that was built for one scene: its vehicle, no simulated robot, and the same heap trap.
#include "firmware_like/heap_watch.hpp"
#include "firmware_like/program.hpp"
#include "firmware_like/vehicles/registry.hpp"
#include "rt/posix/heap_trap.hpp"

int main(int argc, char** argv) {
  namespace firmware = sortie::firmware;
  if (sortie::rt::posix::kHeapTrapAvailable) {
    firmware::set_heap_watch(
        {[](bool on) { on ? sortie::rt::posix::heap_trap_arm() : sortie::rt::posix::heap_trap_disarm(); },
         [] { return sortie::rt::posix::heap_trap_calls(); }});
  }
  return firmware::run_program(argc, argv, {"sortie", firmware::own_vehicles(), nullptr});
}
