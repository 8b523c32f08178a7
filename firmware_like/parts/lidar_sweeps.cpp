// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/lidar_sweeps.hpp"

#include <algorithm>
#include <tuple>

#include "firmware_like/parts/ugv_map_config.hpp"

namespace sortie::firmware {

LidarSweepsConfig read_sweeps(Profile& profile, double min_range_m, double max_range_m) {
  ScanLimits limits;
  profile.read("limits", limits);
  LidarSweepsConfig sweeps{read_sweep_config(profile), limits.buffers, limits.points};
  sweeps.sweep.min_range_m = min_range_m;
  sweeps.sweep.max_range_m = max_range_m;
  return sweeps;
}

LidarSweeps::LidarSweeps(VehicleBuilder& builder, rt::GroupId group, const LidarSweepsConfig& config)
    : poses_(poses_since_last_job(builder, group)),
      points_(config.points),
      min_m_(config.sweep.min_range_m),
      max_m_(config.sweep.max_range_m) {
  std::tie(lidar_.scans, port_) = builder.scans(group, "SCAN", config.buffers, config.points);
  lidar_.p_body_m = config.sweep.p_body_sensor_m;
  lidar_.q_body = config.sweep.q_body_sensor;
  lidar_.time_offset_ns = config.sweep.time_offset_ns;
  placed_.resize(lidar_.scans->batch());
  builder.offer(lidar_);
  builder.offer(*this);
  if (poses_ == nullptr) return;
  flippers_ = builder.input(group, builder.find<rt::Task<planner::FlipperOutput>>(), 1);
  sweeps_ = std::make_unique<mapping::Sweeps>(
      config.sweep, builder.arena().make_array<rt::ScanPoint>("straight scan", config.points));
}

void LidarSweeps::share(VehicleBuilder& builder, double min_m, double max_m) {
  shared_min_m_ = min_m;
  shared_max_m_ = max_m;
  if (sweeps_ == nullptr) return;
  static_cast<void>(set_ranges(min_m_, max_m_));  // both are ranges
  if (placed_.size() > 1)
    kept_ = builder.arena().make_array<rt::ScanPoint>("straight scans", (placed_.size() - 1) * points_);
}

Status LidarSweeps::set_ranges(double min_m, double max_m) {
  if (sweeps_ == nullptr) return Status::ok;
  const Status status = sweeps_->set_ranges(std::min(min_m, shared_min_m_), std::max(max_m, shared_max_m_));
  if (status != Status::ok) return status;
  min_m_ = min_m;
  max_m_ = max_m;
  return status;
}

void LidarSweeps::begin(const rt::JobContext& context) {
  if (context.job == job_) return;
  job_ = context.job;
  count_ = 0;
  take_poses();
}

void LidarSweeps::take_poses() {
  if (poses_ == nullptr) return;
  for (const rt::PoseEstimate& pose : *poses_) {
    // The odometry puts out at every release, with the stamp of its last sample; a sweep and its delay must
    // fit into the history.
    if (pose.stamp_ns < next_pose_ns_) continue;
    if (sweeps_->add({pose.stamp_ns, rt::to_vector(pose.p_world_body_m),
                      rt::to_quaternion(pose.q_world_body)}) == Status::ok)
      next_pose_ns_ = pose.stamp_ns + kPoseEveryNs;
  }
  if (flippers_ == nullptr) return;
  for (const planner::FlipperOutput& output : *flippers_) {
    if ((output.flags & planner::kFlippersMeasured) == 0) continue;
    rt::FlipperSample sample;
    for (std::uint32_t i = 0; i < rt::kFlippers; ++i) sample.angle_rad[i] = output.measured_rad[i];
    static_cast<void>(sweeps_->add(sample));  // what is not finite does not come off the bus
  }
}

const PlacedScan& LidarSweeps::place(std::uint32_t index) {
  for (; count_ <= index; ++count_) {
    const ScanStream::View view = (*lidar_.scans)[count_];
    placed_[count_] = straighten({view.header, view.elements});
    const bool moved = placed_[count_].scan.points != view.elements;
    if (moved && !kept_.empty() && count_ + 1 < size()) keep(placed_[count_], count_);
  }
  return placed_[index];
}

PlacedScan LidarSweeps::straighten(const rt::PointScan& scan) {
  PlacedScan placed;
  placed.scan = scan;
  if ((scan.header.flags & rt::kScanPosed) != 0) {
    placed.placed = true;
    placed.T_odom_sensor = {rt::to_vector(scan.header.p_world_sensor_m),
                            rt::to_quaternion(scan.header.q_world_sensor)};
    return placed;
  }
  if (sweeps_ == nullptr) {
    placed.counts.unplaced = scan.header.points;
    return placed;
  }
  const mapping::StraightSweep sweep = sweeps_->straighten(scan);
  placed.counts = sweep.counts;
  if (sweep.status != Status::ok) return placed;
  placed.scan = sweep.scan;
  placed.placed = true;
  placed.T_odom_sensor = {sweep.pose.p_world_sensor_m, sweep.pose.q_world_sensor};
  return placed;
}

// The next scan is straightened into the same memory.
void LidarSweeps::keep(PlacedScan& placed, std::uint32_t index) {
  const std::span<rt::ScanPoint> own = kept_.subspan(std::size_t{index} * points_, points_);
  std::copy_n(placed.scan.points, placed.scan.header.points, own.begin());
  placed.scan.points = own.data();
}

void LidarSweeps::archive(rt::Archive& archive) {
  if (sweeps_ == nullptr) return;
  archive.value(next_pose_ns_);
  archive.value(*sweeps_);
}

}  // namespace sortie::firmware
