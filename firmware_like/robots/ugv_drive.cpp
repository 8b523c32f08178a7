// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's drive and flippers: their tasks, and their commands on the bus.
#include <stdexcept>
#include <tuple>

#include "firmware_like/parts/own_frames.hpp"
#include "firmware_like/parts/ugv_drive_config.hpp"
#include "firmware_like/parts/ugv_motors.hpp"
#include "firmware_like/robots/ugv.hpp"
#include "firmware_like/runtime/live_keys.hpp"

namespace sortie::firmware {

void Ugv::add_drive(VehicleBuilder& builder, rt::GroupId group) {
  Profile& profile = builder.profile();
  DriveSetup setup = read_drive_setup(builder);
  std::vector<std::string> postures;
  const bool wants_flippers = builder.wants("flippers", false);
  if (rt::kBuilt<rt::Part::flippers> && wants_flippers) {
    const FlipperSetup flippers = read_flipper_setup(builder);
    postures = flippers.names;
    flippers_ = std::make_unique<planner::FlipperPostures>();
    if (flippers_->set_up(flippers.postures, flippers.config) != Status::ok)
      profile.fail("flippers.postures", "cannot be used");
  }
  setup.config.postures = static_cast<std::int32_t>(postures.size());
  request_rules_ = {setup.config.postures, setup.config.max_command_age_ns};
  drive_ = std::make_unique<planner::UgvDrive>(setup.config);
  if (drive_->set_route(read_route(builder)) != Status::ok)
    profile.fail("mission.waypoints", "every waypoint must lie within 1000 km of the origin");
  if (drive_->set_mission(read_mission(builder, postures)) != Status::ok)
    profile.fail("mission.commands", "rows of one nanosecond are one row");
  live_keys<planner::UgvDriveConfig>(builder, group, "drive", *drive_);
  live_keys(builder, group, "drive", *drive_, setup.icr);
  if (setup.remote)
    std::tie(requests_, request_port_) = builder.stream<rt::DriveRequest>(group, "DRIVE", 16, 8);
  drive_outlet_ = builder.outlet<rt::DriveCommand>(group, "drive");
  const rt::TaskBase* task = builder.task<planner::UgvDriveOutput>(
      group, "drive", 50, [this](rt::JobContext& context, planner::UgvDriveOutput& output) {
        if (requests_ != nullptr) {
          // A refusal is counted in the output, by its reason.
          for (const rt::DriveRequest& request : *requests_)
            static_cast<void>(drive_->request(request, context.release_ns));
        }
        // Whatever cannot be used makes the robot stop, and the output says why.
        static_cast<void>(
            drive_->update(odometry_task_->value(), {imu_->stale(), tracks_->stale()}, context.release_ns));
        output = drive_->output();
        drive_outlet_->put(drive_->command());
      });
  builder.remembers(task, *drive_);
  add_drive_counters(builder);
  if (rt::kBuilt<rt::Part::flippers> && flippers_) add_flippers(builder, group);
  add_motors(builder);
  emergency_.set_up(builder);
}

void Ugv::add_motors(VehicleBuilder& builder) {
  const MotorsConfig config = read_motors(builder.profile(), flippers_ != nullptr);
  try {
    // Guarded so that a build without a protocol has no code of it; what it lacks was refused before.
    if constexpr (rt::kBuilt<rt::Part::canopen>) {
      if (config.canopen) motors_ = make_canopen(builder, *config.canopen);
    }
    if constexpr (rt::kBuilt<rt::Part::odrive>) {
      if (config.odrive) motors_ = make_odrive(builder, *config.odrive);
    }
  } catch (const std::runtime_error& error) {
    builder.profile().fail("drives.protocol", error.what());
  }
}

// Motors on a protocol of their own have said theirs.
void Ugv::add_bus_frames(VehicleBuilder& builder) {
  using namespace drivers;
  const std::uint32_t imu[] = {kCanImuGyrId, kCanImuAccId};
  const std::uint32_t tracks[] = {kCanTrackLeftId, kCanTrackRightId};
  const std::uint32_t states[] = {kCanFlipperStateId, kCanFlipperStateId + 1, kCanFlipperStateId + 2,
                                  kCanFlipperStateId + 3};
  const std::uint32_t drive[] = {kCanDriveId};
  const std::uint32_t flippers[] = {kCanFlipperFrontId, kCanFlipperRearId};
  if (imu_ != nullptr) add_device_frames(builder, imu, "can.imu_hz", 200, "how often the IMU sends");
  if (motors_) return;
  if (tracks_ != nullptr)
    add_device_frames(builder, tracks, "can.track_hz", 100, "how often the tracks' encoders send");
  if (flipper_states_ != nullptr)
    add_device_frames(builder, states, "can.flipper_hz", 100, "how often the flippers tell their state");
  if (drive_outlet_ != nullptr) add_own_frames(builder, drive, OwnMotors::kDriveEvery);
  if (flipper_outlet_ != nullptr) add_own_frames(builder, flippers, OwnMotors::kFlippersEvery);
}

void Ugv::add_drive_counters(VehicleBuilder& builder) {
  builder.counter("commands_sent",
                  [this] { return drive_commands_.sent + own_motors_.drive_counters().sent; });
  builder.counter("commands_refused",
                  [this] { return drive_commands_.refused + own_motors_.drive_counters().refused; });
  const planner::UgvDrive* drive = drive_.get();
  builder.counter("waypoints_reached", [drive] { return drive->follower().reached; });
  // Every reason to stop by its name, and what became of requests.
  planner::DriveStopCounters::fields(
      drive->output().stops, [&](const char* name, const std::uint32_t& count) {
        builder.counter(std::string("drive_stops_") + name, [&count] { return std::uint64_t{count}; });
      });
  if (requests_ == nullptr) return;
  planner::RequestCounters::fields(
      drive->output().requests, [&](const char* name, const std::uint32_t& count) {
        builder.counter(std::string("drive_requests_") + name, [&count] { return std::uint64_t{count}; });
      });
}

void Ugv::add_flippers(VehicleBuilder& builder, rt::GroupId group) {
  listen_to_flippers(builder, group);
  own_motors_ = OwnMotors(true);
  flipper_outlet_ = builder.outlet<rt::FlipperCommand>(group, "flippers");
  flipper_task_ = builder.task<planner::FlipperOutput>(
      group, "flippers", 20, [this](rt::JobContext& context, planner::FlipperOutput& output) {
        // What is not finite does not come off the bus; a posture that does not exist is counted in the
        // output.
        for (const rt::FlipperSample& sample : *flipper_states_)
          static_cast<void>(flippers_->observe(sample));
        const planner::UgvDriveOutput& drive = drive_->output();
        const bool hold = (drive.stop & (planner::kStopHalt | planner::kStopTilted)) != 0;
        static_cast<void>(flippers_->update(drive.posture, hold, context.release_ns));
        output = flippers_->output();
        rt::FlipperCommand command;
        command.stamp_ns = output.stamp_ns;
        for (std::uint32_t i = 0; i < rt::kFlippers; ++i) command.angle_rad[i] = output.angle_rad[i];
        command.flags = output.flags & planner::kFlippersEnabled;
        command.asked = drive.asked;  // who asks for motion asks for all of it
        flipper_outlet_->put(command);
      });
  builder.remembers(flipper_task_, *flippers_);
  builder.counter("flipper_commands_sent",
                  [this] { return flipper_commands_.sent + own_motors_.flipper_counters().sent; });
  builder.counter("flipper_commands_refused",
                  [this] { return flipper_commands_.refused + own_motors_.flipper_counters().refused; });
}

void Ugv::send_commands(drivers::CanBus& can, rt::Nanoseconds now_ns) {
  rt::DriveCommand command;
  const bool has_command = drive_outlet_ != nullptr && (motors_ || own_motors_.drive_is_due(now_ns)) &&
                           drive_outlet_->take(now_ns, command);
  rt::FlipperCommand flippers;
  const bool has_flippers = flipper_outlet_ != nullptr && (motors_ || own_motors_.flippers_are_due(now_ns)) &&
                            flipper_outlet_->take(now_ns, flippers);
  if (has_command) emergency_asked_ = (command.flags & rt::kCommandEmergency) != 0;
  const bool pressed = emergency_.poll(emergency_asked_, now_ns);
  const auto reason = motors_ ? static_cast<std::uint32_t>(motors_->stop_reason()) : 0u;
  motors_news_.store((pressed ? 1u : 0u) | (motors_ && motors_->running() ? 2u : 0u) | reason << 8u,
                     std::memory_order_relaxed);
  if (motors_) {
    motors_->press(pressed);
    send_to_motors(can, has_command ? &command : nullptr, has_flippers ? &flippers : nullptr, now_ns);
  } else if (drive_outlet_ != nullptr) {
    own_motors_.poll(can, has_command ? &command : nullptr, has_flippers ? &flippers : nullptr, pressed,
                     now_ns);
  }
}

std::optional<MotorsNews> Ugv::motors_news() const {
  if (!drive_) return {};
  const std::uint32_t word = motors_news_.load(std::memory_order_relaxed);
  return MotorsNews{(word & 1u) != 0, (word & 2u) != 0, word >> 8u};
}

/// These motors say by themselves when something goes out.
void Ugv::send_to_motors(drivers::CanBus& can, const rt::DriveCommand* command,
                         const rt::FlipperCommand* flippers, rt::Nanoseconds now_ns) {
  const auto note = [](Status status, OwnMotors::Counters& counters) {
    ++(status == Status::ok ? counters.sent : counters.refused);
  };
  if (command != nullptr) note(motors_->set(*command, now_ns), drive_commands_);
  if (flippers != nullptr) note(motors_->set(*flippers, now_ns), flipper_commands_);
  motors_->poll(now_ns, can);
  // A full stream counts its refusals.
  rt::TrackSample tracks;
  if (motors_->read(tracks) == Status::ok && track_port_ != nullptr)
    static_cast<void>(track_port_->push(tracks, now_ns));
  rt::FlipperSample state;
  if (motors_->read(state) == Status::ok && flipper_port_ != nullptr)
    static_cast<void>(flipper_port_->push(state, now_ns));
}

}  // namespace sortie::firmware
