// SPDX-License-Identifier: BSD-3-Clause
// What the scan before saw to be empty: a return of the next scan that stands there says that its pose is
// wrong.
#pragma once

#include <span>

#include "mapping/grid/rolling_grid_config.hpp"
#include "mapping/registration/scan_sample.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

/// The nearest return in each of some directions about a sensor, as a table of azimuth and elevation. Memory:
/// 4 bytes a direction, 10 kB.
class SeenSpace {
 public:
  static constexpr int kTurns = 72;  ///< directions about the upright
  static constexpr int kRises = 36;  ///< from straight down to straight up
  static constexpr std::size_t kDirections = std::size_t{kTurns} * kRises;

  /// `ranges`: kDirections of them. `planar`: all returns lie in the sensor's own plane.
  explicit SeenSpace(std::span<float> ranges, bool planar = false) : ranges_(ranges), planar_(planar) {}

  /// Takes a scan's sample, seen from `pose`. An arc tangent a return.
  void take(std::span<const SamplePoint> sample, const RigidPose& pose);

  /// Of the returns of another sample at a pose: the share that stands where this one's rays went on. Only
  /// those count for which the rays of this one went past on all sides. 0 where it has seen nothing. An
  /// arc tangent and nine looks a return.
  double share_inside(std::span<const SamplePoint> sample, const RigidPose& pose) const;

  void archive(rt::Archive& archive);

 private:
  static bool direction(const rt::Vector3& v, double range_m, int& turn, int& rise);
  float& at(int turn, int rise) const { return ranges_[static_cast<std::size_t>(rise * kTurns + turn)]; }

  std::span<float> ranges_;
  bool planar_;
  RigidPose pose_;
  bool some_{};
};

}  // namespace sortie::mapping
