// SPDX-License-Identifier: BSD-3-Clause
// The vehicle's scans as its mapping tasks see them: each straightened and placed once.
#pragma once

#include <memory>
#include <vector>

#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/sensor_mount.hpp"
#include "mapping/grid/rolling_grid_config.hpp"
#include "mapping/grid/sweep.hpp"
#include "planner/flipper_postures.hpp"

namespace sortie::firmware {

/// What scans are, and the memory for them.
struct LidarSweepsConfig {
  mapping::SweepConfig sweep;
  ScanLimits scans;
};

/// Reads [lidar], [outline], [limits] and the keys of [map] that say how sweeps are straightened, for a part
/// that wants returns of these ranges. Throws ProfileError.
LidarSweepsConfig read_sweeps(Profile& profile, double min_range_m, double max_range_m);

/// Scans of channel SCAN in a group. Those that carry a pose stay as they are; others are straightened return
/// by return with the odometry's poses, and freed of the robot itself; without a pose for them they are not
/// placed. The first part that needs it makes it and offers it to those behind it. No heap after
/// construction; deterministic.
class LidarSweeps {
 public:
  /// Opens the stream, offers this object. Throws ProfileError.
  LidarSweeps(VehicleBuilder& builder, rt::GroupId group, const LidarSweepsConfig& config);

  /// At the beginning of each task that reads scans: takes poses, once a job.
  void begin(const rt::JobContext& context);
  /// Scans of this job.
  std::uint32_t size() const { return scans_->size(); }
  ScanStream::View operator[](std::uint32_t index) const { return (*scans_)[index]; }
  /// Scan `index` of this job, in rising order. Its status is ok where it is placed; its pose is then that of
  /// the sensor in the odometry's frame. Without odometry one that has no pose is as it came. Lives until the
  /// next one is asked for; of a shared one (see share()) until the job's end. Cost: as of
  /// Sweeps::straighten(), the first time in a job.
  const mapping::StraightSweep& place(std::uint32_t index);

  /// A second task reads the same scans, and wants returns of these ranges, too. Set-up only. Takes memory
  /// for all but the last of a job's scans.
  void share(VehicleBuilder& builder, double min_m, double max_m);
  /// Other ranges of the first reader: returns out of these and of those of share() are left out. Status: as
  /// of Sweeps::set_ranges().
  Status set_ranges(double min_m, double max_m);

  /// How the lidar sits on the body, and its clock.
  const mapping::SweepConfig& config() const { return config_; }
  ScanPort* port() const { return port_; }
  /// Most points of a scan.
  std::uint32_t points() const { return points_; }
  /// False: only scans that carry a pose can be placed.
  bool has_odometry() const { return sweeps_ != nullptr; }

  void archive(rt::Archive& archive);

 private:
  static constexpr rt::Nanoseconds kPoseEveryNs = 2 * rt::kNanosecondsPerMillisecond;
  static constexpr std::uint64_t kNoJob = ~std::uint64_t{0};

  void take_poses();
  mapping::StraightSweep straighten(const rt::PointScan& scan);
  void keep(mapping::StraightSweep& placed, std::uint32_t index);

  rt::Input<rt::PoseEstimate>* poses_{};  // null without odometry
  rt::Input<planner::FlipperOutput>* flippers_{};
  mapping::SweepConfig config_;  // its ranges are those of the first reader
  ScanStream* scans_{};
  ScanPort* port_{};
  std::unique_ptr<mapping::Sweeps> sweeps_;     // null without odometry
  std::vector<mapping::StraightSweep> placed_;  // of this job, as many as a batch has
  std::span<rt::ScanPoint> kept_;  // points of all scans of a batch but its last; empty: not shared
  std::uint32_t points_;
  double shared_min_m_{1e300};
  double shared_max_m_{};
  rt::Nanoseconds next_pose_ns_{};
  std::uint64_t job_{kNoJob};
  std::uint32_t count_{};  // placed in this job
};

}  // namespace sortie::firmware
