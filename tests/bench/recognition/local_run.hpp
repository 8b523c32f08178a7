// SPDX-License-Identifier: BSD-3-Clause
// A robot's local map and the segments in it that may speak, scan after scan, as they run on board.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "mapping/recognition/local_segments.hpp"
#include "mapping/recognition/recogniser.hpp"
#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {

/// How far a pose is off.
struct PoseError {
  double move_m{};
  double turn_deg{};
  /// Farther off is another place.
  bool is_right() const { return move_m <= 1.0 && turn_deg <= 5.0; }
};
PoseError error_of(const mapping::RigidPose& told, const mapping::RigidPose& truth);

/// T_known_odom that a set of segments says.
mapping::RigidPose pose_of(const mapping::LevelPlace& place);

/// An arena with memory of its own.
struct TrialMemory {
  std::unique_ptr<std::byte[]> bytes;
  rt::Arena arena;
  explicit TrialMemory(std::size_t mb) : bytes(new std::byte[mb << 20]), arena({bytes.get(), mb << 20}) {}
  /// Throws std::runtime_error where something found no room.
  void check() const;
};

/// Smooth segments in voxels of 0.1 m, returns up to 25 m; a scan each half second, a round each second.
class LocalRun {
 public:
  explicit LocalRun(double radius_m);

  /// True: a round was due, and the segments are new. Throws std::runtime_error where a world does not fit.
  bool scan(const std::vector<rt::ScanPoint>& points, const mapping::RigidPose& T_odom_sensor);

  const mapping::RollingGrid& grid() const { return map_.grid(); }
  std::span<const mapping::WatchedSegment> segments() const { return segments_.segments(); }
  const mapping::SegmentWatchCounts& counts() const { return segments_.counts(); }
  rt::Nanoseconds now_ns() const { return now_ns_; }
  /// Those that speak, the nearest `most` of them; places in the odometry's frame.
  std::vector<mapping::SpeakingSegment> speaking(std::uint32_t most) const;
  /// The map's voxels, in the odometry's frame, m.
  std::vector<rt::Vector3> voxels() const;

 private:
  TrialMemory memory_;
  tests::SmoothMap map_;
  mapping::LocalSegments segments_;
  rt::Nanoseconds now_ns_{}, round_ns_{};
  rt::Tick tick_{};
};

}  // namespace sortie::bench
