// SPDX-License-Identifier: BSD-3-Clause
// A trajectory that cannot outgrow its memory, however long a run lasts.
#pragma once

#include <cstddef>

#include "firmware_like/evaluation/trajectory.hpp"

namespace sortie::firmware {

/// Keeps poses at a spacing that doubles whenever `most` of them are held: then every second one is dropped.
/// The first pose stays. Memory: at most `most` poses (about 80 bytes each).
class BoundedTrajectory {
 public:
  /// `spacing_ns`: least time between two kept poses at the beginning.
  explicit BoundedTrajectory(std::int64_t spacing_ns, std::size_t most = std::size_t{1} << 20)
      : spacing_ns_(spacing_ns), most_(most) {}

  /// Takes a pose, unless it comes too soon after the last kept one.
  void add(const TimedPose& pose) {
    if (!poses_.empty() && pose.stamp_ns < poses_.back().stamp_ns + spacing_ns_) return;
    if (poses_.size() >= most_) thin();
    poses_.push_back(pose);
  }

  /// What was kept, oldest first.
  Trajectory take() { return std::move(poses_); }
  std::size_t size() const { return poses_.size(); }

 private:
  void thin() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < poses_.size(); i += 2) poses_[kept++] = poses_[i];
    poses_.resize(kept);
    spacing_ns_ *= 2;
  }

  Trajectory poses_;
  std::int64_t spacing_ns_;
  std::size_t most_;
};

}  // namespace sortie::firmware
