// SPDX-License-Identifier: BSD-3-Clause
// A robot that drives a long way, keeps what it sees, and looks whether it has been there before.
#pragma once

#include <limits>
#include <optional>

#include "mapping/registration/relocate_config.hpp"
#include "tests/bench/recognition/local_run.hpp"
#include "tests/bench/recognition/street_town.hpp"

namespace sortie::bench {

/// Settings of a drive.
struct LoopDriveConfig {
  double radius_m{20.0};     ///< of the local map
  double lately_m{100.0};    ///< of way: what was seen since is no target
  double drift_deg{0.1};     ///< of heading, a root of a metre (a random walk)
  double drift_share{0.01};  ///< of way: both a bias and a step's noise
  std::uint32_t targets{16'384};
  mapping::RecogniserConfig recogniser;
  mapping::RelocateConfig judge;
};

/// A look, once a metre of way.
struct LoopLook {
  double way_m{};      ///< driven so far
  double nearest_m{};  ///< to the nearest place that was left more than `lately_m` before; may be infinite
  std::uint32_t speaking{};
  std::uint32_t agree{};            ///< segments of the best place
  mapping::SetVerdict verdict{};    ///< by segments alone
  std::optional<PoseError> found;   ///< where `verdict` is found
  std::optional<PoseError> placed;  ///< where a scan fits there, too
};
inline bool is_right(const std::optional<PoseError>& told) { return told && told->is_right(); }
inline bool is_wrong(const std::optional<PoseError>& told) { return told && !told->is_right(); }

/// A drive and what was looked at.
struct LoopDrive {
  std::vector<LoopLook> looks;
  std::size_t scans{};
  std::uint32_t targets{};  ///< kept at the end
  std::uint64_t evicted{};  ///< given up for want of room
  double drifted_m{};       ///< the odometry at the end
  double drifted_deg{};
};

/// Drives a course, a metre a second with two scans in it, by odometry that drifts. Segments become targets
/// at their place in the odometry; those not seen lately are the candidates. A found place is off by what the
/// scan's pose differs from the one in the odometry as it was when the robot was there before: of all times
/// at which it was within kSeen_m, where that differs least.
LoopDrive drive_loops(const StreetCourse& course, const StreetTown& town, const HallLidar& lidar,
                      const LoopDriveConfig& config, testing::Draws& draws);

}  // namespace sortie::bench
