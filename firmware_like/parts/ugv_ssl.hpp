// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's solid-state lidar: a map of what is known, rays that are asked for, what comes back.
#pragma once

#include <memory>

#include "drivers/ssl_port.hpp"
#include "firmware_like/parts/lidar_sweeps.hpp"
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/ugv_ssl_config.hpp"
#include "mapping/grid/pose_history.hpp"
#include "planner/ray_plan.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

/// What the task puts out.
struct SslOutput {
  rt::Nanoseconds stamp_ns{};  ///< of the newest frame
  std::uint32_t asked{};       ///< number of the newest command
  std::uint32_t answered{};    ///< number of the command that the newest frame answers
  std::uint64_t frames{};      ///< taken
  std::uint64_t rays{};        ///< in them
  std::uint64_t returns{};     ///< of those that met something
  std::uint64_t unasked{};   ///< frames with the number of no command, or of one that was answered: not taken
  std::uint64_t unplaced{};  ///< rays of taken frames that no pose was known for: not in the map
  std::uint64_t range_sum_mm{};  ///< of the newest frame
  std::uint32_t nearest_mm{};    ///< of the newest frame; 0: nothing came back
  std::uint32_t oldest_10us{};   ///< age of the frame's first ray
  std::uint64_t map_changes{};   ///< of the map that was planned over (mapping::OccupancyOutput)
  std::uint64_t rays_digest{};   ///< xxhash64 of the directions that are asked for, two bytes each
  std::uint32_t stage{};         ///< of the newest plan (planner::RayStage)
  planner::RaySummary plan;      ///< of the same
  std::uint64_t unplanned{};     ///< commands that had no plan: strides
  SORTIE_FIELDS(stamp_ns, asked, answered, frames, rays, returns, unasked, unplaced, range_sum_mm, nearest_mm,
                oldest_10us, map_changes, rays_digest, stage, plan, unplanned)
};

/// Tasks of the group `mapping`. `occupancy`, only where rays are scheduled: moves the map's window with the
/// robot and enters the lidar's scans. `ssl`, an anytime task: enters what came back, plans over the map, and
/// asks for the next rays, which leave at the job's deadline. Both share the map, on one thread.
class UgvSsl final : public Part {
 public:
  explicit UgvSsl(VehicleBuilder& builder);

  /// Times a unit of the scheduler on this machine; nothing where rays are not scheduled.
  UnitTrial try_units() const override;
  /// Nothing where rays are not scheduled.
  std::optional<mapping::OccupancyView> occupancy() const override {
    return map_ ? std::optional(map_->view()) : std::nullopt;
  }
  /// Commands that are due go to the device and into the log, frames come in.
  void poll_devices(const Devices& devices, rt::Nanoseconds now_ns) override;

 private:
  // True when the map needs poses and scans.
  bool schedules() const {
    return rt::kBuilt<"ray_scheduler"> && settings_.choice.policy == planner::SslPolicy::scheduled;
  }
  void add_task(VehicleBuilder& builder);
  void add_occupancy(VehicleBuilder& builder);
  void add_counters(VehicleBuilder& builder, const rt::Task<SslOutput>* task);
  void send(const Devices& devices, const rt::SslCommand& command, rt::Nanoseconds now_ns);
  void take_poses();
  void enter_scan(const rt::PointScan& scan);
  void take(const rt::SslReturns& returns, SslOutput& output);
  void enter(const rt::SslReturns& returns, SslOutput& output);
  void plan(rt::JobContext& context, SslOutput& output);

  rt::GroupId group_;
  SslSettings settings_;
  OccupancySettings map_settings_;
  const LidarSweeps* lidar_{};            // null without one
  rt::Input<rt::PoseEstimate>* poses_{};  // only where rays are scheduled
  rt::Vector3 p_body_ssl_;
  rt::Quaternion q_body_ssl_;
  const rt::Task<SslOutput>* task_{};
  rt::Stream<rt::SslReturns>* returns_{};
  InputPort<rt::SslReturns>* port_{};
  rt::CommandOutlet<rt::SslCommand>* outlet_{};
  std::unique_ptr<planner::SslChoice> choice_;
  // Only where rays are scheduled.
  std::unique_ptr<mapping::OccupancyMap> map_;
  std::unique_ptr<mapping::PoseHistory> history_;
  rt::PoseEstimate newest_{};  // pose; its stamp 0: none yet
  std::uint64_t scans_unplaced_{};
  std::uint64_t planned_job_{};  // release of the newest plan
  std::int64_t commands_sent_{};
  std::uint64_t commands_refused_{};
};

}  // namespace sortie::firmware
