// SPDX-License-Identifier: BSD-3-Clause
// How vehicles and simulated robots are made, for those who only pass the makers on.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace sortie::drivers {
class ScanSink;
}  // namespace sortie::drivers

namespace sortie::firmware {

class SimulatedRobot;
class Profile;
class Vehicle;
class VehicleBuilder;

/// Makes a vehicle. Throws ProfileError.
using VehicleFactory = std::function<std::unique_ptr<Vehicle>(VehicleBuilder&)>;

/// Vehicles by the name that [scene] vehicle gives.
using VehicleRegistry = std::vector<std::pair<std::string, VehicleFactory>>;

/// Makes the simulated robot of a profile, or null if it has none. `scans`: where its lidar delivers.
using SimulatorFactory = std::function<std::unique_ptr<SimulatedRobot>(Profile&, drivers::ScanSink* scans)>;

}  // namespace sortie::firmware
