// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_ssl.hpp"

#include <algorithm>
#include <tuple>

#include "drivers/wire_ssl.hpp"
#include "planner/ssl_horizon.hpp"
#include "rt/digest.hpp"

namespace sortie::firmware {

namespace {

// Units between two looks at the clock's guard.
constexpr std::uint32_t kSlice = 4096;
// A pose that is older says nothing about where the next rays begin.
constexpr rt::Nanoseconds kMostAheadNs = 2'000'000'000;

}  // namespace

UgvSsl::UgvSsl(VehicleBuilder& builder)
    : group_(builder.group("mapping", 10)),
      settings_(read_ssl_settings(builder.profile())),
      map_settings_(read_occupancy_settings(builder.profile(), settings_)) {
  const SensorMount mount = read_ssl_mount(builder.profile());
  p_body_ssl_ = rt::to_vector(mount.place_m);
  q_body_ssl_ = mount.q_body_sensor();
  if (schedules()) add_occupancy(builder);
  add_task(builder);
}

void UgvSsl::add_task(VehicleBuilder& builder) {
  const std::uint64_t bytes = planner::SslChoice::memory_bytes(settings_.choice);
  choice_ = std::make_unique<planner::SslChoice>(
      settings_.choice,
      bytes == 0 ? std::span<std::byte>{}
                 : builder.arena().make_array<std::byte>("ray scheduler", static_cast<std::size_t>(bytes),
                                                         alignof(std::max_align_t)));
  std::tie(returns_, port_) = builder.stream<rt::SslReturns>(group_, std::string(drivers::kChannelSsl), 8, 4);
  outlet_ = builder.outlet<rt::SslCommand>(group_, "ssl");
  const TaskDefaults defaults{schedules() ? 30'000.0 : 100.0, rt::Criticality::b, settings_.units, true};
  task_ =
      builder.task<SslOutput>(group_, "ssl", defaults, [this](rt::JobContext& context, SslOutput& output) {
        for (const rt::SslReturns& returns : *returns_) take(returns, output);
        if (schedules()) plan(context, output);
        rt::SslCommand command;
        choice_->choose(context.due_ns, command);
        output.asked = command.number;
        output.rays_digest = rt::digest_bytes(command.direction, command.rays * sizeof(command.direction[0]));
        output.unplanned = choice_->unplanned();
        outlet_->put(command);
      });
  builder.remembers(task_, *choice_, planned_job_);
  add_counters(builder, task_);
}

void UgvSsl::add_occupancy(VehicleBuilder& builder) {
  lidar_ = builder.find<LidarSweeps>();
  poses_ = poses_since_last_job(builder, group_);
  if (poses_ == nullptr)
    builder.profile().fail("ssl.policy", "\"scheduled\" needs poses: tasks.attitude and tasks.odometry");
  map_ = std::make_unique<mapping::OccupancyMap>(
      map_settings_.map,
      builder.arena().make_array<std::int8_t>(
          "occupancy", static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(map_settings_.map))));
  history_ = std::make_unique<mapping::PoseHistory>();
  const rt::TaskBase* task = builder.task<mapping::OccupancyOutput>(
      group_, "occupancy", TaskDefaults{15'000, rt::Criticality::b},
      [this](rt::JobContext& context, mapping::OccupancyOutput& output) {
        take_poses();
        // A place that is none leaves the window where it is; rays from outside are counted.
        if (newest_.stamp_ns != 0) static_cast<void>(map_->centre_on(rt::to_vector(newest_.p_world_body_m)));
        for (std::uint32_t i = 0; lidar_ != nullptr && i < lidar_->size(); ++i) {
          const ScanStream::View view = (*lidar_)[i];
          context.add_units(view.header.points / map_settings_.scan_stride);
          enter_scan({view.header, view.elements});
        }
        output = map_->output();
      });
  builder.remembers(task, *map_, *history_, newest_, scans_unplaced_);
  const mapping::OccupancyMap* map = map_.get();
  builder.counter("occupancy_rays", [map] { return map->output().rays; });
  builder.uses("SCAN", [map] { return map->output().used; });
  builder.counter("occupancy_used", [map] { return map->output().used; });
  builder.counter("occupancy_outside", [map] { return map->output().outside; });
  builder.counter("occupancy_not_finite", [map] { return map->output().not_finite; });
  builder.counter("occupancy_too_near", [map] { return map->output().too_near; });
  builder.counter("occupancy_known", [map] { return map->output().known; });
  builder.counter("occupancy_scans_unplaced", [this] { return scans_unplaced_; });
}

void UgvSsl::add_counters(VehicleBuilder& builder, const rt::Task<SslOutput>* task) {
  builder.counter("ssl_commands_sent", [this] { return static_cast<std::uint64_t>(commands_sent_); });
  builder.counter("ssl_commands_refused", [this] { return commands_refused_; });
  builder.counter("ssl_frames", [task] { return task->value().frames; });
  builder.counter("ssl_unasked", [task] { return task->value().unasked; });
  if (!schedules()) return;
  builder.counter("ssl_unplaced", [task] { return task->value().unplaced; });
  builder.counter("ssl_unplanned", [task] { return task->value().unplanned; });
}

UnitTrial UgvSsl::try_units() const {
  if (!schedules()) return {};
  UnitTrial trial = try_ray_units(settings_.choice, map_settings_.map);
  trial.task = "ssl";
  trial.units = task_->spec().units;
  trial.budget_us = task_->spec().budget_us;
  return trial;
}

void UgvSsl::take_poses() {
  // Refusals are poses without news: the odometry repeats its last stamp until the next sample.
  for (const rt::PoseEstimate& pose : *poses_) {
    if (history_->add({pose.stamp_ns, rt::to_vector(pose.p_world_body_m),
                       rt::to_quaternion(pose.q_world_body)}) == Status::ok)
      newest_ = pose;
  }
}

void UgvSsl::enter_scan(const rt::PointScan& scan) {
  mapping::SensorPose sensor{rt::to_vector(scan.header.p_world_sensor_m),
                             rt::to_quaternion(scan.header.q_world_sensor)};
  if ((scan.header.flags & rt::kScanPosed) == 0) {
    mapping::StampedPose body;
    const rt::Nanoseconds at = scan.header.stamp_ns + lidar_->config().time_offset_ns;
    if (history_->at(at, map_settings_.max_pose_age_ns, body) != Status::ok) {
      ++scans_unplaced_;
      return;
    }
    sensor =
        planner::mounted({body.p, body.q}, lidar_->config().p_body_sensor_m, lidar_->config().q_body_sensor);
  }
  // What is refused stands in the map's output.
  static_cast<void>(map_->update(scan, sensor, map_settings_.scan_stride));
}

void UgvSsl::take(const rt::SslReturns& returns, SslOutput& output) {
  if (returns.number > output.asked || returns.number <= output.answered) {
    ++output.unasked;
    return;
  }
  output.stamp_ns = returns.stamp_ns;
  output.answered = returns.number;
  ++output.frames;
  output.rays += returns.rays;
  output.range_sum_mm = 0;
  output.nearest_mm = 0;
  output.oldest_10us = 0;
  for (std::uint32_t i = 0; i < returns.rays; ++i) {
    const std::uint32_t range_mm = returns.range_mm[i];
    output.oldest_10us = std::max(output.oldest_10us, std::uint32_t{returns.age_10us[i]});
    if (range_mm == 0) continue;
    ++output.returns;
    output.range_sum_mm += range_mm;
    if (output.nearest_mm == 0 || range_mm < output.nearest_mm) output.nearest_mm = range_mm;
  }
  if (map_) enter(returns, output);
}

// Each ray from where the sensor was when it was fired.
void UgvSsl::enter(const rt::SslReturns& returns, SslOutput& output) {
  for (std::uint32_t i = 0; i < returns.rays; ++i) {
    const bool hit = returns.range_mm[i] != 0;
    const double range_m = hit ? rt::kSslRangeStep_m * returns.range_mm[i] : map_settings_.silent_free_m;
    if (!(range_m > 0.0)) continue;
    const rt::Nanoseconds at = returns.stamp_ns - 10'000 * rt::Nanoseconds{returns.age_10us[i]};
    mapping::StampedPose body;
    if (history_->at(at, map_settings_.max_pose_age_ns, body) != Status::ok) {
      ++output.unplaced;
      continue;
    }
    const mapping::SensorPose sensor = planner::mounted({body.p, body.q}, p_body_ssl_, q_body_ssl_);
    const rt::Vector3 way = rt::rotate(sensor.q_world_sensor, rt::ssl_direction(returns.direction[i]));
    // Refusals are counted by the map.
    static_cast<void>(
        map_->update_ray(sensor.p_world_sensor_m, sensor.p_world_sensor_m + range_m * way, hit));
  }
}

void UgvSsl::plan(rt::JobContext& context, SslOutput& output) {
  output.map_changes = map_->output().changes;
  // The rays leave at the deadline; those of the next commands one period after the other behind it.
  const rt::Nanoseconds ahead_ns = context.due_ns - newest_.stamp_ns;
  if (newest_.stamp_ns != 0 && ahead_ns >= 0 && ahead_ns <= kMostAheadNs) {
    mapping::SensorPose poses[planner::RayScheduler::kMostPositions];
    const std::uint32_t positions = settings_.choice.scheduler.positions;
    for (std::uint32_t i = 0; i < positions; ++i) {
      const double ahead_s = 1e-9 * static_cast<double>(ahead_ns + i * context.period_ns);
      poses[i] = planner::mounted(planner::body_ahead(newest_, ahead_s), p_body_ssl_, q_body_ssl_);
    }
    const std::uint64_t passed = context.job - planned_job_;
    const auto passed_positions = static_cast<std::uint32_t>(std::min<std::uint64_t>(passed, positions));
    // Without a plan there are strides, and a count of them.
    if (choice_->begin(map_->view(), {poses, positions}, passed_positions) == Status::ok)
      planned_job_ = context.job;
  }
  while (!choice_->done()) {
    const std::uint32_t slice = std::min(kSlice, context.units_left());
    if (slice == 0 || !context.spend(slice)) break;
    static_cast<void>(choice_->step(slice));
  }
  const planner::RayPlan* plan = choice_->plan();
  if (plan == nullptr) return;
  output.stage = static_cast<std::uint32_t>(plan->stage);
  output.plan = *plan;  // its summary alone
}

void UgvSsl::send(const Devices& devices, const rt::SslCommand& command, rt::Nanoseconds now_ns) {
  if (devices.ssl == nullptr || devices.ssl->send(command) != Status::ok) {
    ++commands_refused_;
    return;
  }
  if (devices.log != nullptr) {
    std::uint8_t message[drivers::kSslCommandBytes];
    std::size_t size = 0;
    if (drivers::encode(command, commands_sent_, message, size) == Status::ok)
      devices.log->sample(std::string(drivers::kChannelSslCommand), now_ns, {message, size});
  }
  ++commands_sent_;
}

void UgvSsl::poll_devices(const Devices& devices, rt::Nanoseconds now_ns) {
  rt::SslCommand command;
  if (outlet_->take(now_ns, command)) send(devices, command, now_ns);
  if (devices.ssl == nullptr) return;
  rt::SslReturns returns;
  // A full stream counts its refusals.
  for (int taken = 0; taken < 8 && devices.ssl->receive(returns) == Status::ok; ++taken)
    static_cast<void>(port_->push(returns, now_ns));
}

std::unique_ptr<Part> make_ssl(VehicleBuilder& builder) { return std::make_unique<UgvSsl>(builder); }

}  // namespace sortie::firmware
