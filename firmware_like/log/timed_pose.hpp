// SPDX-License-Identifier: BSD-3-Clause
// Trajectories as lists of stamped poses: what a log holds and what a run gives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
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

/// Keeps values with a `stamp_ns` at a spacing that doubles whenever `most` of them are held: then every
/// second one is dropped. The first one stays. Memory: at most `most` values.
template <class T>
class BoundedSeries {
 public:
  /// `spacing_ns`: least time between two kept values at the beginning.
  explicit BoundedSeries(std::int64_t spacing_ns, std::size_t most = std::size_t{1} << 20)
      : spacing_ns_(spacing_ns), most_(most) {}

  /// Takes a value, unless it comes too soon after the last kept one.
  void add(const T& value) {
    if (!values_.empty() && value.stamp_ns < values_.back().stamp_ns + spacing_ns_) return;
    if (values_.size() >= most_) thin();
    values_.push_back(value);
  }

  /// What was kept, oldest first.
  std::vector<T> take() { return std::move(values_); }
  std::size_t size() const { return values_.size(); }

 private:
  void thin() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values_.size(); i += 2) values_[kept++] = values_[i];
    values_.resize(kept);
    spacing_ns_ *= 2;
  }

  std::vector<T> values_;
  std::int64_t spacing_ns_;
  std::size_t most_;
};

/// A trajectory that cannot outgrow its memory, however long a run lasts: about 80 bytes a pose.
using BoundedTrajectory = BoundedSeries<TimedPose>;

}  // namespace sortie::firmware
