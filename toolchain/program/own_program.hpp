// SPDX-License-Identifier: BSD-3-Clause
// The one header of a robot engineer's own program: own vehicle and own simulated devices in, every command
// of `sortie` out, with the heap trap on the tasks. Link Sortie::firmware and Sortie::heap_trap.
#pragma once

#include <memory>

#include "firmware_like/live/simulated_robot.hpp"
#include "firmware_like/runtime/heap_watch.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "toolchain/program/program.hpp"

namespace sortie::toolchain {

/// Factory of a vehicle class with a constructor V(VehicleBuilder&).
template <class V>
std::unique_ptr<firmware::Vehicle> make_vehicle(firmware::VehicleBuilder& builder) {
  return std::make_unique<V>(builder);
}

/// Factory of a simulated robot of class B with a constructor B(Profile&). A scene without [hil] has none.
template <class B>
std::unique_ptr<firmware::SimulatedRobot> make_simulated(firmware::Profile& profile, drivers::ScanSink*) {
  return profile.has("hil") ? std::make_unique<B>(profile) : nullptr;
}

/// run_program() with every heap call of a task counted, as `heap_calls` in the result. Call it from main().
inline int run_own_program(int argc, char** argv, const ProgramParts& parts) {
  firmware::watch_heap();
  return run_program(argc, argv, parts);
}

}  // namespace sortie::toolchain
