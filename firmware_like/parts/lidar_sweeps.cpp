// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/lidar_sweeps.hpp"

#include <algorithm>
#include <tuple>

namespace sortie::firmware {
namespace {

/// Body frame: x forward, y left, z up, origin on the ground between the tracks.
mapping::SelfFilterConfig read_outline(Profile& profile) {
  mapping::SelfFilterConfig c;
  c.margin_m = profile.number("outline.margin_m",
                              {c.margin_m, 0, 1, "m", "as far from the robot a return still is the robot"});
  c.shadow_m = profile.number(
      "outline.shadow_m",
      {0, 0, 1, "m",
       "a return whose ray passes the robot as near as this is left out: it may be its edge; 0: none is"});
  const char* meaning = "least x, y, z and most x, y, z of the body in its own frame; all 0: no such part";
  for (const char* path : {"outline.body_m", "outline.tracks_m"}) {
    const std::vector<double> b =
        profile.numbers(path, std::vector<double>(6, 0.0), {0, -10, 10, "m", meaning});
    meaning = "the same of all between and with the tracks";
    if (std::all_of(b.begin(), b.end(), [](double value) { return value == 0.0; })) continue;
    if (!(b[0] < b[3] && b[1] < b[4] && b[2] < b[5])) profile.fail(path, "the most must be above the least");
    mapping::BodyBox& box = c.boxes[c.box_count++];
    box.centre_m = {0.5 * (b[0] + b[3]), 0.5 * (b[1] + b[4]), 0.5 * (b[2] + b[5])};
    box.half_m = {0.5 * (b[3] - b[0]), 0.5 * (b[4] - b[1]), 0.5 * (b[5] - b[2])};
  }
  c.flippers.large_radius_m = 0.1;
  c.flippers.small_radius_m = c.flippers.half_width_m = 0.03;
  profile.read("outline", c.flippers);
  if (c.flippers.length_m == 0.0) c.flippers = {};
  if (mapping::SelfFilter(c).usable() != Status::ok)
    profile.fail("outline.flipper_length_m", "one wheel of the flipper would hold the other");
  return c;
}

}  // namespace

LidarSweepsConfig read_sweeps(Profile& profile, double min_range_m, double max_range_m) {
  LidarSweepsConfig config;
  profile.read("limits", config.scans);
  const SensorMount mount = read_lidar_mount(profile);
  mapping::SweepConfig& sweep = config.sweep;
  sweep.p_body_sensor_m = rt::to_vector(mount.place_m);
  sweep.q_body_sensor = mount.q_body_sensor();
  profile.read("map", sweep);
  sweep.robot = read_outline(profile);
  sweep.min_range_m = min_range_m;
  sweep.max_range_m = max_range_m;
  return config;
}

LidarSweeps::LidarSweeps(VehicleBuilder& builder, rt::GroupId group, const LidarSweepsConfig& config)
    : poses_(poses_since_last_job(builder, group)), config_(config.sweep), points_(config.scans.points) {
  std::tie(scans_, port_) = builder.scans(group, "SCAN", config.scans.buffers, config.scans.points);
  placed_.resize(scans_->batch());
  builder.offer(*this);
  if (poses_ == nullptr) return;
  flippers_ = builder.input(group, builder.find<rt::Task<planner::FlipperOutput>>(), 1);
  sweeps_ = std::make_unique<mapping::Sweeps>(
      config.sweep, builder.arena().make_array<rt::ScanPoint>("straight scan", points_));
}

void LidarSweeps::share(VehicleBuilder& builder, double min_m, double max_m) {
  shared_min_m_ = min_m;
  shared_max_m_ = max_m;
  if (sweeps_ == nullptr) return;
  static_cast<void>(set_ranges(config_.min_range_m, config_.max_range_m));  // both are ranges
  if (placed_.size() > 1)
    kept_ = builder.arena().make_array<rt::ScanPoint>("straight scans", (placed_.size() - 1) * points_);
}

Status LidarSweeps::set_ranges(double min_m, double max_m) {
  if (sweeps_ == nullptr) return Status::ok;
  const Status status = sweeps_->set_ranges(std::min(min_m, shared_min_m_), std::max(max_m, shared_max_m_));
  if (status != Status::ok) return status;
  config_.min_range_m = min_m;
  config_.max_range_m = max_m;
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
    // Angles that are not finite do not come off the bus.
    static_cast<void>(sweeps_->set_flippers(output.measured_rad));
  }
}

const mapping::StraightSweep& LidarSweeps::place(std::uint32_t index) {
  for (; count_ <= index; ++count_) {
    const ScanStream::View view = (*this)[count_];
    placed_[count_] = straighten({view.header, view.elements});
    const bool moved = placed_[count_].scan.points != view.elements;
    if (moved && !kept_.empty() && count_ + 1 < size()) keep(placed_[count_], count_);
  }
  return placed_[index];
}

mapping::StraightSweep LidarSweeps::straighten(const rt::PointScan& scan) {
  const bool posed = (scan.header.flags & rt::kScanPosed) != 0;
  if (sweeps_ != nullptr && !posed) return sweeps_->straighten(scan);
  mapping::StraightSweep placed;
  placed.scan = scan;
  placed.counts.in = scan.header.points;
  (posed ? placed.counts.used : placed.counts.unplaced) = scan.header.points;
  if (posed) {
    placed.pose = {rt::to_vector(scan.header.p_world_sensor_m),
                   rt::to_quaternion(scan.header.q_world_sensor)};
  } else {
    placed.status = Status::empty;  // there are no poses
  }
  return placed;
}

// The next scan is straightened into the same memory.
void LidarSweeps::keep(mapping::StraightSweep& placed, std::uint32_t index) {
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
