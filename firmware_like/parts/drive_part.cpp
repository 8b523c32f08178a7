// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's drive and flippers: their tasks, what is told of them, and their commands on the bus,
// whatever protocol its motors speak.
#include <atomic>
#include <stdexcept>
#include <tuple>

#include "drivers/can_codec.hpp"
#include "drivers/can_frames.hpp"
#include "firmware_like/parts/emergency_inputs.hpp"
#include "firmware_like/parts/odometry_part.hpp"
#include "firmware_like/parts/own_frames.hpp"
#include "firmware_like/parts/own_motors.hpp"
#include "firmware_like/parts/ugv_drive_config.hpp"
#include "firmware_like/parts/ugv_motors.hpp"
#include "firmware_like/runtime/live_keys.hpp"
#include "planner/ground_way/ground_way_follower.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {
namespace {

/// Group `control`, behind the odometry: tasks `drive` and, where the robot has them, `flippers`. On the I/O
/// thread: their commands to the motors, whatever protocol those speak, and the emergency stop.
class DrivePart final : public Part {
 public:
  explicit DrivePart(VehicleBuilder& builder)
      : odometry_(*builder.find<OdometryPart>()), group_(builder.find<AttitudePart>()->group()) {
    Profile& profile = builder.profile();
    DriveSetup setup = read_drive_setup(builder);
    std::vector<std::string> postures;
    const bool wants_flippers = builder.wants("flippers", false);
    if (rt::kBuilt<"flippers"> && wants_flippers) {
      const FlipperSetup flippers = read_flipper_setup(builder);
      postures = flippers.names;
      flippers_ = std::make_unique<planner::FlipperPostures>();
      if (flippers_->set_up(flippers.postures, flippers.config) != Status::ok)
        profile.fail("flippers.postures", "cannot be used");
    }
    setup.config.postures = static_cast<std::int32_t>(postures.size());
    const bool finds_ways = builder.wants("way", false);
    if (rt::kBuilt<"way"> && finds_ways) {
      planner::GroundWayFollowerConfig config;
      profile.read("way", config);
      guide_ = std::make_unique<planner::GroundWayFollower>(config);
      setup.config.finds_ways = true;
    }
    request_rules_ = {setup.config.postures, setup.config.max_command_age_ns, setup.config.finds_ways};
    drive_ = std::make_unique<planner::UgvDrive>(setup.config);
    if (drive_->set_route(read_route(builder)) != Status::ok)
      profile.fail("mission.waypoints", "every waypoint must lie within 1000 km of the origin");
    if (drive_->set_mission(read_mission(builder, postures)) != Status::ok)
      profile.fail("mission.commands", "rows of one nanosecond are one row");
    if (rt::kBuilt<"way"> && guide_) read_goal(profile);
    live_keys<planner::UgvDriveConfig>(builder, group_, "drive", *drive_);
    live_keys(builder, group_, "drive", *drive_, setup.icr);
    if (setup.remote)
      std::tie(requests_, request_port_) = builder.stream<rt::DriveRequest>(group_, "DRIVE", 16, 8);
    add_task(builder);
    add_counters(builder);
    if (rt::kBuilt<"flippers"> && flippers_) add_flippers(builder);
    add_motors(builder);
    emergency_.set_up(builder);
  }

  void finish(VehicleBuilder& builder) override {
    builder.chain({"imu_to_drive", {"IMU", "attitude", "odometry", "drive"}});
    if (rt::kBuilt<"way"> && guide_)
      way_ = builder.input(group_, builder.find<rt::Task<planner::GroundWay>>(), 1);
    if (motors_) return;  // motors on a protocol of their own have said their frames
    using namespace drivers;
    const std::uint32_t drive[] = {kCanDriveId};
    const std::uint32_t flippers[] = {kCanFlipperFrontId, kCanFlipperRearId};
    add_own_frames(builder, drive, OwnMotors::kDriveEvery);
    if (flipper_outlet_ != nullptr) add_own_frames(builder, flippers, OwnMotors::kFlippersEvery);
  }

  void open_devices() override { emergency_.open(); }
  bool take_frame(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) override {
    return emergency_.take(frame, now_ns) || (motors_ && motors_->take(frame, now_ns));
  }

  void heard(const drivers::CanSample& sample, rt::Nanoseconds now_ns) override {
    if (sample.kind == drivers::CanSampleKind::track) own_motors_.note_tracks(now_ns);
  }

  void poll_devices(const Devices& devices, rt::Nanoseconds now_ns) override {
    if (devices.can == nullptr) return;
    rt::DriveCommand command;
    const bool has_command =
        (motors_ || own_motors_.drive_is_due(now_ns)) && drive_outlet_->take(now_ns, command);
    rt::FlipperCommand flippers;
    const bool has_flippers = flipper_outlet_ != nullptr &&
                              (motors_ || own_motors_.flippers_are_due(now_ns)) &&
                              flipper_outlet_->take(now_ns, flippers);
    if (has_command) emergency_asked_ = (command.flags & rt::kCommandEmergency) != 0;
    const bool pressed = emergency_.poll(emergency_asked_, now_ns);
    const auto reason = motors_ ? static_cast<std::uint32_t>(motors_->stop_reason()) : 0u;
    motors_news_.store((pressed ? 1u : 0u) | (motors_ && motors_->running() ? 2u : 0u) | reason << 8u,
                       std::memory_order_relaxed);
    const rt::DriveCommand* drive = has_command ? &command : nullptr;
    const rt::FlipperCommand* angles = has_flippers ? &flippers : nullptr;
    if (motors_) {
      motors_->press(pressed);
      send_to_motors(*devices.can, drive, angles, now_ns);
    } else {
      own_motors_.poll(*devices.can, drive, angles, pressed, now_ns);
    }
  }

  std::optional<MotorsNews> motors_news() const override {
    const std::uint32_t word = motors_news_.load(std::memory_order_relaxed);
    return MotorsNews{(word & 1u) != 0, (word & 2u) != 0, word >> 8u};
  }

  RequestEntry<rt::DriveRequest> drive_requests() override { return {request_port_, request_rules_}; }

 private:
  void add_task(VehicleBuilder& builder) {
    drive_outlet_ = builder.outlet<rt::DriveCommand>(group_, "drive");
    const rt::Stream<rt::ImuSample>& imu = builder.find<AttitudePart>()->imu();
    rt::Task<planner::UgvDriveOutput>* task = builder.task<planner::UgvDriveOutput>(
        group_, "drive", 50, [this, &imu](rt::JobContext& context, planner::UgvDriveOutput& output) {
          if (requests_ != nullptr) {
            // A refusal is counted in the output, by its reason.
            for (const rt::DriveRequest& request : *requests_)
              static_cast<void>(drive_->request(request, context.release_ns));
          }
          // Whatever cannot be used makes the robot stop, and the output says why.
          const rt::PoseEstimate& pose = odometry_.pose_task()->value();
          planner::UgvDriveInputs inputs{imu.stale(), odometry_.tracks().stale()};
          if (rt::kBuilt<"way"> && guide_) inputs.guide = guide(pose, context.release_ns);
          static_cast<void>(drive_->update(pose, inputs, context.release_ns));
          output = drive_->output();
          drive_outlet_->put(output);
        });
    builder.offer(*task);
    if (rt::kBuilt<"way"> && guide_) {
      builder.remembers(task, *drive_, *guide_, guided_);
    } else {
      builder.remembers(task, *drive_);
    }
  }

  void add_counters(VehicleBuilder& builder) {
    builder.counter("commands_sent",
                    [this] { return drive_commands_.sent + own_motors_.drive_counters().sent; });
    builder.counter("commands_refused",
                    [this] { return drive_commands_.refused + own_motors_.drive_counters().refused; });
    builder.counter("waypoints_reached", [this] { return drive_->follower().reached; });
    if (rt::kBuilt<"way"> && guide_) builder.counters("way_follower_", guide_->counters());
    // Every reason to stop by its name, and what became of requests.
    builder.counters("drive_stops_", drive_->output().stops);
    if (requests_ != nullptr) builder.counters("drive_requests_", drive_->output().requests);
  }

  void add_flippers(VehicleBuilder& builder) {
    flipper_states_ = flipper_states(builder, group_);
    own_motors_ = OwnMotors(true);
    flipper_outlet_ = builder.outlet<rt::FlipperCommand>(group_, "flippers");
    rt::Task<planner::FlipperOutput>* task = builder.task<planner::FlipperOutput>(
        group_, "flippers", 20, [this](rt::JobContext& context, planner::FlipperOutput& output) {
          // What is not finite does not come off the bus; an unknown posture is counted in the output.
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
    builder.offer(*task);
    builder.remembers(task, *flippers_);
    builder.counter("flipper_commands_sent",
                    [this] { return flipper_commands_.sent + own_motors_.flipper_counters().sent; });
    builder.counter("flipper_commands_refused",
                    [this] { return flipper_commands_.refused + own_motors_.flipper_counters().refused; });
  }

  void add_motors(VehicleBuilder& builder) {
    track_port_ = builder.find_port<rt::TrackSample>("TRACK");
    flipper_port_ = builder.find_port<rt::FlipperSample>("FLIPPER");
    const MotorsConfig config = read_motors(builder.profile(), flippers_ != nullptr);
    try {
      // Guarded so that a build without a protocol has no code of it; what it lacks was refused before.
      if constexpr (rt::kBuilt<"canopen">) {
        if (config.canopen) motors_ = make_canopen(builder, *config.canopen);
      }
      if constexpr (rt::kBuilt<"odrive">) {
        if (config.odrive) motors_ = make_odrive(builder, *config.odrive);
      }
    } catch (const std::runtime_error& error) {
      builder.profile().fail("drives.protocol", error.what());
    }
    if (motors_) builder.offer(*motors_);
  }

  /// These motors say by themselves when something goes out.
  void send_to_motors(drivers::CanBus& can, const rt::DriveCommand* command,
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

  /// [goal]: where to go from the start on.
  void read_goal(Profile& profile) {
    if (!profile.has("goal.x_m") && !profile.has("goal.y_m")) return;
    const double far_m = planner::kFarthestGoal_m;
    const double x_m = profile.number(
        "goal.x_m", {0, -far_m, far_m, "m", "where to go by a way of its own, in the world of the start"});
    const double y_m = profile.number("goal.y_m", {0, -far_m, far_m, "m", "the same"});
    if (drive_->set_goal(x_m, y_m) != Status::ok) profile.fail("goal.x_m", "no place to go to");
  }

  /// What the way's follower says of the goal in force.
  planner::GoalGuide guide(const rt::PoseEstimate& pose, rt::Nanoseconds now_ns) {
    if (guided_ != drive_->goal()) guide_->forget();
    guided_ = drive_->goal();
    const planner::GroundWay* way = way_ != nullptr ? way_->latest() : nullptr;
    if (guided_ != 0 && way != nullptr) guide_->take(*way, guided_);
    planner::GoalGuide guide;
    if (guided_ != 0 && drive_->follows_guide()) {
      guide.wish = guide_->wish(pose, drive_->limits(), drive_->ramps(), now_ns);
    } else {
      guide_->pause();
    }
    guide.has_way = guide_->has_way(now_ns);
    guide.arrived = guide_->arrived();
    guide.turning = guide_->turning();
    guide.reversing = guide_->reversing();
    guide.lost = guide_->lost();
    guide.series = guide_->series();
    guide.step = guide_->step();
    return guide;
  }

  const OdometryPart& odometry_;
  rt::GroupId group_;
  rt::Stream<rt::DriveRequest>* requests_{};
  InputPort<rt::DriveRequest>* request_port_{};
  planner::RequestRules request_rules_;
  std::unique_ptr<planner::UgvDrive> drive_;
  std::unique_ptr<planner::GroundWayFollower> guide_;  // null where the robot finds no ways
  rt::Input<planner::GroundWay>* way_{};
  std::uint32_t guided_{};  // number of the goal that it follows
  rt::CommandOutlet<rt::DriveCommand>* drive_outlet_{};
  // Null where the scene has no flippers.
  std::unique_ptr<planner::FlipperPostures> flippers_;
  rt::Stream<rt::FlipperSample>* flipper_states_{};
  rt::CommandOutlet<rt::FlipperCommand>* flipper_outlet_{};
  // The I/O thread's.
  std::unique_ptr<drivers::UgvDrives> motors_;  ///< null: they speak the robot's own frames
  OwnMotors own_motors_;
  EmergencyInputs emergency_;
  bool emergency_asked_{};                    // by the newest command
  std::atomic<std::uint32_t> motors_news_{};  // MotorsNews in one word, so that it is read whole
  OwnMotors::Counters drive_commands_;        // that motors of another protocol took, or refused
  OwnMotors::Counters flipper_commands_;
  InputPort<rt::TrackSample>* track_port_{};
  InputPort<rt::FlipperSample>* flipper_port_{};
};

}  // namespace

std::unique_ptr<Part> make_drive(VehicleBuilder& builder) { return std::make_unique<DrivePart>(builder); }

}  // namespace sortie::firmware
