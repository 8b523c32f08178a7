// SPDX-License-Identifier: BSD-3-Clause
// The desktop program: own vehicles, simulated robots, and a heap trap that watches the tasks.
#include "firmware_like/commands/bench_ugv.hpp"
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
  return firmware::run_program(argc, argv, {"sortie", firmware::own_vehicles(), firmware::make_own_bench});
}
