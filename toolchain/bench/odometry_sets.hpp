// SPDX-License-Identifier: BSD-3-Clause
// Recordings and drives over which the odometry is measured, as lists of samples in the order of their
// receipt.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estimators/attitude_config.hpp"
#include "estimators/track_odometry.hpp"
#include "firmware_like/live/simulated_robot.hpp"
#include "firmware_like/log/log_file.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "toolchain/judge/evaluate.hpp"

namespace sortie::toolchain {

/// Samples of one device that a job takes, or takes next.
struct OdometryEvent {
  enum class Kind : std::uint8_t { flippers, imu, track };
  std::int64_t received_us{};
  Kind kind{Kind::imu};
  std::uint32_t index{};  ///< into the list of its kind
};

/// One recording and how it is judged.
struct OdometrySet {
  std::string name;
  std::string error;         ///< of Evaluation::errors, the one that counts
  double rate_hz{};          ///< of the inertial sensor
  double profile_rate_hz{};  ///< what the scene's own sensor sends; 0: the recording's
  double duration_s{};
  std::vector<rt::ImuSample> imu;
  std::vector<rt::TrackSample> track;
  std::vector<rt::FlipperSample> flippers;
  std::vector<OdometryEvent> events;
  firmware::Trajectory truth;
  EvaluationOptions evaluation;
  estimators::AttitudeConfig attitude;
  bool track_aid{};
  bool has_odometry{};
  estimators::TrackOdometryConfig odometry;
};

/// Reads the samples of a log and, of its scene (or `scene`), the estimators' settings. Throws InputError,
/// ProfileError.
OdometrySet read_odometry_set(const firmware::LogFile& log, const std::string& scene);

/// Drives a scene of the program's own on a virtual clock with an inertial sensor of 1 kHz and hardly a
/// lidar. Throws what run_live throws.
OdometrySet drive_odometry_set(const firmware::VehicleRegistry& vehicles,
                               const firmware::SimulatorFactory& simulator, const std::string& scene,
                               double seconds);

/// A set with every `every`-th inertial sample, each the mean of so many: what a slower sensor had sent.
OdometrySet thinned(const OdometrySet& set, std::uint32_t every);

}  // namespace sortie::toolchain
