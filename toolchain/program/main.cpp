// SPDX-License-Identifier: BSD-3-Clause
// The desktop program: own vehicles, simulated robots, and a heap trap that watches the tasks.
#include "firmware_like/robots/registry.hpp"
#include "toolchain/program/own_program.hpp"
#include "toolchain/simulate/simulated_ugv.hpp"

int main(int argc, char** argv) {
  using namespace sortie;
  return toolchain::run_own_program(argc, argv,
                                    {"sortie", firmware::own_vehicles(), toolchain::make_simulated_robot});
}
