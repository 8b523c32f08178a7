// SPDX-License-Identifier: BSD-3-Clause
// Trajectories as lists of stamped poses: what a log holds and what a run gives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rt/located_pose.hpp"
#include "rt/samples.hpp"

namespace sortie::firmware {

/// A pose of the body in a fixed frame at one time. Flags say which parts mean something (rt::TruthFlags).
struct TimedPose {
  std::int64_t stamp_ns{};
  double p[3]{};            ///< m
  double q[4]{1, 0, 0, 0};  ///< w x y z, rotates body vectors into the fixed frame
  std::uint32_t flags{rt::kTruthPosition | rt::kTruthHeight | rt::kTruthOrientation};
};

/// Poses in ascending order of stamp.
using Trajectory = std::vector<TimedPose>;

/// The pose of a truth sample. Flags are kept as they are.
TimedPose to_timed_pose(const rt::TruthSample& truth);

/// The pose of an estimate; all parts are meant.
TimedPose to_timed_pose(const rt::PoseEstimate& estimate);

/// The body's pose on the map, also of a scan that was refused; all parts are meant.
/// Without a stamp, which is none, where the robot's place on a kept map is not known.
TimedPose to_timed_pose(const rt::LocatedPose& located);

/// Sorts by stamp (stable), normalises quaternions and removes samples that are not finite or have no
/// direction. Repeated stamps stay, as evo keeps them. Returns how many samples were removed.
std::size_t tidy(Trajectory& trajectory);

/// Scales a quaternion (w x y z) to length 1.
void make_unit(double (&q)[4]);

}  // namespace sortie::firmware
