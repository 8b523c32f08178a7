// SPDX-License-Identifier: BSD-3-Clause
// Installed only: the header of a robot of one's own under the path and with the names that such projects
// know.
#pragma once

#include "toolchain/program/own_program.hpp"

namespace sortie::firmware {

using BenchRobot = SimulatedRobot;
using toolchain::make_vehicle;
using toolchain::ProgramParts;
using toolchain::run_own_program;
using toolchain::run_program;

/// make_simulated() by the name that it had.
template <class B>
std::unique_ptr<SimulatedRobot> make_bench(Profile& profile, drivers::ScanSink* scans) {
  return toolchain::make_simulated<B>(profile, scans);
}

}  // namespace sortie::firmware
