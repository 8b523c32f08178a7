// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/uav_sensing.hpp"

#include <cmath>
#include <tuple>
#include <utility>

#include "firmware_like/parts/sensor_mount.hpp"

namespace sortie::firmware {

namespace {

// What a cell is given that the vehicle itself has been in.
constexpr double kBubbleChance = 0.01;

}  // namespace

UavSensing::UavSensing(VehicleBuilder& builder, rt::GroupId group, std::function<bool()> asked,
                       const rt::Vector3& bubble_m)
    : settings_(read_occupancy_settings(builder.profile())), bubble_m_(bubble_m) {
  ScanLimits limits;
  builder.profile().read("limits", limits);
  const SensorMount mount = read_lidar_mount(builder.profile());
  p_body_lidar_ = rt::to_vector(mount.place_m);
  q_body_lidar_ = mount.q_body_sensor();
  rt::Input<rt::PoseEstimate>* const poses = poses_since_last_job(builder, group);
  map_ = std::make_unique<mapping::OccupancyMap>(
      settings_.map,
      builder.arena().make_array<std::int8_t>(
          "occupancy", static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(settings_.map))));
  history_ = std::make_unique<mapping::PoseHistory>();
  std::tie(scans_, port_) = builder.scans(group, "SCAN", limits.buffers, limits.points);
  const rt::TaskBase* task = builder.task<mapping::OccupancyOutput>(
      group, "occupancy", TaskDefaults{15'000, rt::Criticality::b},
      [this, poses, asked = std::move(asked)](rt::JobContext& context, mapping::OccupancyOutput& output) {
        take_poses(*poses);
        if (newest_.stamp_ns != 0) {
          // A place that is none leaves the window where it is; rays from outside are counted.
          static_cast<void>(map_->centre_on(rt::to_vector(newest_.p_world_body_m)));
          if (!asked()) clear_bubble();
        }
        for (std::uint32_t i = 0; i < scans_->size(); ++i) {
          const ScanStream::View view = (*scans_)[i];
          context.add_units(view.header.points / settings_.scan_stride);
          enter({view.header, view.elements});
        }
        output = map_->output();
      });
  builder.remembers(task, *map_, *history_, newest_, scans_entered_, points_unplaced_);
  const mapping::OccupancyMap* map = map_.get();
  builder.counter("occupancy_scans", [this] { return scans_entered_; });
  builder.counter("occupancy_points_unplaced", [this] { return points_unplaced_; });
  builder.counter("occupancy_rays", [map] { return map->output().rays; });
  builder.uses("SCAN", [map] { return map->output().used; });
  builder.counter("occupancy_used", [map] { return map->output().used; });
  builder.counter("occupancy_outside", [map] { return map->output().outside; });
  builder.counter("occupancy_too_near", [map] { return map->output().too_near; });
  builder.counter("occupancy_known", [map] { return map->output().known; });
}

void UavSensing::take_poses(rt::Input<rt::PoseEstimate>& poses) {
  // Refusals are poses without news.
  for (const rt::PoseEstimate& pose : poses) {
    if (pose.stamp_ns == 0) continue;  // no place yet
    if (history_->add({pose.stamp_ns, rt::to_vector(pose.p_world_body_m),
                       rt::to_quaternion(pose.q_world_body)}) == Status::ok)
      newest_ = pose;
  }
}

// The vehicle was set down with this much room; where it stands it cannot see.
void UavSensing::clear_bubble() {
  const mapping::OccupancyView view = map_->view();
  const rt::Vector3 middle = view.to_window(rt::to_vector(newest_.p_world_body_m));
  if (!view.contains(middle)) return;
  const double s = 1.0 / view.voxel_size_m;
  const rt::Vector3 r{s * bubble_m_.x, s * bubble_m_.y, s * bubble_m_.z};
  const auto whole = [](double value) { return static_cast<std::int32_t>(std::floor(value)); };
  const int code = mapping::OccupancyMap::code_of(kBubbleChance);
  for (std::int32_t z = whole(middle.z - r.z); z <= whole(middle.z + r.z); ++z) {
    for (std::int32_t y = whole(middle.y - r.y); y <= whole(middle.y + r.y); ++y) {
      for (std::int32_t x = whole(middle.x - r.x); x <= whole(middle.x + r.x); ++x) {
        if (!view.contains({x + 0.5, y + 0.5, z + 0.5})) continue;
        const double dx = (x + 0.5 - middle.x) / r.x;
        const double dy = (y + 0.5 - middle.y) / r.y;
        const double dz = (z + 0.5 - middle.z) / r.z;
        if (dx * dx + dy * dy + dz * dz > 1.0) continue;
        const std::int64_t row = std::int64_t{z} * view.size[1] + y;
        if (view.cells[row * view.size[0] + x] == mapping::kUnknownCell) map_->set(x, y, z, code);
      }
    }
  }
}

// Each ray from where the lidar was: a turn takes long enough to fly a voxel.
void UavSensing::enter(const rt::PointScan& scan) {
  ++scans_entered_;
  mapping::StampedPose body;
  std::int32_t age_10us = -1;
  bool placed = false;
  rt::Vector3 from;
  rt::Quaternion turn;
  for (std::uint32_t i = 0; i < scan.header.points; i += settings_.scan_stride) {
    const rt::ScanPoint& point = scan.points[i];
    if (point.age_10us != age_10us) {
      age_10us = point.age_10us;
      placed = history_->at(scan.header.stamp_ns - 10'000 * rt::Nanoseconds{age_10us},
                            settings_.max_pose_age_ns, body) == Status::ok;
      from = body.p + rt::rotate(body.q, p_body_lidar_);
      turn = body.q * q_body_lidar_;
    }
    if (!placed) {
      ++points_unplaced_;
      continue;
    }
    const rt::Vector3 seen{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                           static_cast<double>(point.z_m)};
    // Refusals are counted by the map.
    static_cast<void>(map_->update_ray(from, from + rt::rotate(turn, seen), true));
  }
}

}  // namespace sortie::firmware
