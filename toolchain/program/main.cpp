// SPDX-License-Identifier: BSD-3-Clause
// The desktop program: own vehicles, simulated robots, and a heap trap that watches the tasks.
#include "firmware_like/robots/registry.hpp"
#include "firmware_like/runtime/heap_watch.hpp"
#include "rt/posix/heap_trap.hpp"
#include "toolchain/program/program.hpp"
#include "toolchain/simulate/simulated_ugv.hpp"

int main(int argc, char** argv) {
  using namespace sortie;
  if (sortie::rt::posix::kHeapTrapAvailable) {
    firmware::set_heap_watch(
        {[](bool on) { on ? sortie::rt::posix::heap_trap_arm() : sortie::rt::posix::heap_trap_disarm(); },
         [] { return sortie::rt::posix::heap_trap_calls(); }});
  }
  return toolchain::run_program(argc, argv,
                                {"sortie", firmware::own_vehicles(), toolchain::make_simulated_robot});
}
