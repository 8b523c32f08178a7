// SPDX-License-Identifier: BSD-3-Clause
// The parts of [hil], for the simulated robots' own files. All that read a profile throw ProfileError.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <type_traits>

#include "firmware_like/live/simulated_robot.hpp"
#include "firmware_like/scene/profile.hpp"
#include "hil/ugv_plant.hpp"

namespace sortie::toolchain {

/// Reads a number into `value`, which holds the fallback.
template <class T>
void read_number(firmware::Profile& profile, const std::string& path, T& value, double low, double high,
                 const char* unit, const char* meaning) {
  const firmware::NumberSpec spec{static_cast<double>(value), low, high, unit, meaning};
  if constexpr (std::is_integral_v<T>)
    value = static_cast<T>(profile.integer(path, spec));
  else
    value = profile.number(path, spec);
}

/// Reads rates, noise, ranges, stamps' errors and losses of the simulated IMU and encoders.
void read_inertial(firmware::Profile& profile, hil::UgvConfig& config);
/// The IMU's part of that.
void read_imu_alone(firmware::Profile& profile, hil::ImuConfig& imu, hil::FaultConfig& faults);

/// Reads [hil] lidar_*, [hil.lidar], [hil.ssl] and the mounts T_body_lidar ([lidar]) and T_body_ssl ([ssl]):
/// the simulated sensors sit where the vehicle believes them to be.
void read_range_sensors(firmware::Profile& profile, hil::UgvConfig& config);
/// Counts of rays. A sensor that is not there adds none.
void add_range_counters(const hil::UgvPlant& plant, std::map<std::string, std::uint64_t>& counters);

/// Reads hil.contacts and what belongs to it, a robot with contacts on a course of obstacles, into a config
/// whose start pose and sensors are already there.
void read_course(firmware::Profile& profile, hil::UgvConfig& config);

/// Makes the multirotor of [hil] for vehicle "uav": plant, sensors, world, CAN bus, and a lidar that
/// delivers to `scans`, which may be null.
std::unique_ptr<firmware::SimulatedRobot> make_simulated_uav(firmware::Profile& profile,
                                                             drivers::ScanSink* scans);

}  // namespace sortie::toolchain
