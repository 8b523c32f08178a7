// SPDX-License-Identifier: BSD-3-Clause
// Simulated halls with a robot in them: a map of a few scans, further scans, and starts beside the truth.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "mapping/registration/locator.hpp"
#include "rt/arena.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::bench {

/// A scan and where it was taken.
struct PlacedScan {
  std::vector<rt::ScanPoint> points;
  mapping::RigidPose pose;
};

/// A random hall and poses in it where a robot could stand: 0.4 m clear of everything.
class Hall {
 public:
  explicit Hall(testing::Draws& draws) : world_(testing::random_hall(draws)) {}
  /// Within 2 m of the middle, any heading, leaning up to 0.1 rad.
  PlacedScan scan(testing::Draws& draws, const testing::TestLidar& lidar = {}) const;

 private:
  testing::RegistrationWorld world_;
};

/// A registration with its memory.
struct OwnedRegistration {
  explicit OwnedRegistration(const mapping::RegistrationConfig& config)
      : memory(std::size_t{24} << 20), arena(memory), registration(config, arena) {}

  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::ScanRegistration registration;
};

/// How a start is off.
struct StartError {
  double move_m{};
  double turn_rad{};
  bool upright{};  ///< turned about the vertical, moved mostly level; else about and along any axis
};

/// `pose` moved by exactly `move_m` and turned by exactly `turn_rad`.
mapping::RigidPose start_beside(const mapping::RigidPose& pose, const StartError& error,
                                testing::Draws& draws);

/// What is known of a start beside it: `odometry` that is good to 2 m and 2 rad, or, alone, that the robot is
/// somewhere here, 10 m and 10 rad. Alone, the registration looks for other poses that do as well.
enum class Known { odometry, alone };
mapping::PosePrior loose_prior(const mapping::RigidPose& at, Known known);

/// Distance of a pose from the truth.
struct PoseError {
  double move_m{};
  double turn_deg{};
  bool within(double m, double deg) const { return move_m < m && turn_deg < deg; }
};
PoseError pose_error(const mapping::RigidPose& pose, const mapping::RigidPose& truth);

/// CPU time of this thread.
double step_cpu_ms();

}  // namespace sortie::bench
