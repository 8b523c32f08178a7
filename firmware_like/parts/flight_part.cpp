// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/flight_part.hpp"

#include <tuple>

#include "drivers/can_codec.hpp"
#include "firmware_like/parts/own_frames.hpp"
#include "firmware_like/runtime/live_keys.hpp"

namespace sortie::firmware {

FlightPart::FlightPart(VehicleBuilder& builder) : control_(builder.group("control", 200)) {
  // Without a map of another robot to be placed on its own frame is the mission's.
  const bool wants_join = builder.wants("join", false);
  seeks_ = rt::kBuilt<"join"> && wants_join && builder.kept_map("join") != nullptr;
  // What is asked for and not built was refused before.
  const bool wants_pilot = builder.wants("pilot");
  const bool flies = rt::kBuilt<"pilot"> && wants_pilot;
  if (rt::kBuilt<"pilot"> && flies) make_pilot(builder, control_);
  add_state(builder, control_);
  builder.offer(imu_kind_);
  builder.offer(*pose_task_);
  if (!(rt::kBuilt<"pilot"> && flies)) return;
  add_pilot(builder, control_);
  const bool wants_path = builder.wants("path", false);
  if (rt::kBuilt<"path"> && wants_path) add_path(builder, control_);
}

void FlightPart::finish(VehicleBuilder& builder) {
  using namespace drivers;
  const std::uint32_t imu[] = {kCanImuGyrId, kCanImuAccId};
  const std::uint32_t fix[] = {kCanFixAcrossId, kCanFixUpId};
  const std::uint32_t rotors[] = {kCanRotorsId, kCanRotorsId + 1, kCanRotorsId + 2};
  add_device_frames(builder, imu, "can.imu_hz", 200, "how often the IMU sends");
  add_device_frames(builder, fix, "can.fix_hz", 20, "how often a fix of the place comes");
  if (outlet_ == nullptr) return;
  if (rt::kBuilt<"join"> && seeks_) {
    const auto* place = builder.find<rt::Task<JoinOutput>>();
    place_input_ = builder.input(control_, place, 1);
    if (rt::kBuilt<"path"> && guide_) place_for_way_ = builder.input(way_group_, place, 1);
  }
  const std::size_t frames = (rotor_count_ + 2) / 3;  // three rotors each
  add_own_frames(builder, {rotors, frames}, builder.period_ns(control_));
  builder.chain({"imu_to_rotors", {"IMU", "state", "pose", "pilot"}});
}

void FlightPart::add_state(VehicleBuilder& builder, rt::GroupId group) {
  imu_ = builder.stream<rt::ImuSample>(group, "IMU", 256, 64).first;
  fixes_ = builder.stream<rt::UavFix>(group, "FIX", 32, 8).first;
  estimator_ = std::make_unique<estimators::UavEstimator>(read_uav_estimator_config(builder));
  const rt::TaskBase* task =
      builder.task<rt::UavState>(group, "state", 200, [this](rt::JobContext&, rt::UavState& output) {
        // A backward read: what the pilot's last command makes of the rotors. Refusals are counted.
        const double thrust_m_s2 = rt::kBuilt<"pilot"> && pilot_ ? pilot_->mean_thrust_m_s2() : 9.81;
        for (const rt::ImuSample& sample : *imu_) static_cast<void>(estimator_->imu(sample, thrust_m_s2));
        for (const rt::UavFix& fix : *fixes_) static_cast<void>(estimator_->fix(fix));
        output = estimator_->state();
      });
  builder.remembers(task, *estimator_);
  pose_task_ = builder.task<rt::PoseEstimate>(
      group, "pose", 20, [this](rt::JobContext&, rt::PoseEstimate& output) { put_pose(output); });
  builder.remembers(pose_task_, distance_m_, last_m_, located_);
  const estimators::UavEstimator* estimator = estimator_.get();
  builder.counters("state_", estimator->counters());
  builder.uses("IMU", [estimator] { return estimator->counters().imu_used; });
  builder.uses("FIX", [estimator] { return estimator->counters().fixes_used; });
}

void FlightPart::put_pose(rt::PoseEstimate& pose) {
  const rt::UavState& state = estimator_->state();
  if (state.verdict == rt::UavVerdict::starting) return;  // no place yet: no pose
  pose.stamp_ns = state.stamp_ns;
  const rt::Vector3 p = rt::to_vector(state.p_world_m);
  if (located_) distance_m_ += rt::norm(p - last_m_);
  located_ = true;
  last_m_ = p;
  const rt::Quaternion q = rt::to_quaternion(state.q_world_body);
  rt::store(p, pose.p_world_body_m);
  rt::store(q, pose.q_world_body);
  rt::store(rt::rotate_back(q, rt::to_vector(state.v_world_m_s)), pose.v_body_m_s);
  rt::store(rt::to_vector(state.w_body_rad_s), pose.w_body_rad_s);
  // The filter's order is position, velocity, attitude; its attitude errors are of the body.
  const estimators::ErrorCovariance& p_all = estimator_->covariance();
  for (std::size_t r = 0; r < 6; ++r) {
    for (std::size_t c = 0; c < 6; ++c)
      pose.covariance[6 * r + c] = p_all(r < 3 ? r : r + 3, c < 3 ? c : c + 3);
  }
  pose.distance_m = distance_m_;
  pose.rejected = static_cast<std::uint32_t>(estimator_->counters().imu_refused & 0xFFFFFFFFu);
}

// Before the group's first task: it has a run-time parameter.
void FlightPart::make_pilot(VehicleBuilder& builder, rt::GroupId group) {
  planner::UavPilotConfig config = read_pilot_config(builder);
  rotor_count_ = config.control.model.rotors;
  request_rules_ = {0, config.max_command_age_ns};
  config.plans = builder.wants("path", false);
  pilot_ = std::make_unique<planner::UavPilot>(config);
  if (pilot_->status() != Status::ok)
    builder.profile().fail("airframe.mass_kg", "no stable controller could be designed for this vehicle");
  if (pilot_->set_mission(read_uav_mission(builder)) != Status::ok)
    builder.profile().fail("mission.goals", "every goal must lie within 8 km of the origin");
  const std::vector<planner::UavGoal> looks = read_uav_looks(builder);
  if (rt::kBuilt<"join"> && seeks_) {
    if (looks.empty())
      builder.profile().fail("mission.looks", "a vehicle that seeks its place needs some: heights and yaws");
    static_cast<void>(pilot_->set_looks(looks));  // in range, as read
  }
  live_keys<planner::UavPilotConfig>(builder, group, "flight", *pilot_);
}

void FlightPart::add_pilot(VehicleBuilder& builder, rt::GroupId group) {
  if (builder.profile().flag("flight.remote", false, "requests over LCM may fly the vehicle"))
    std::tie(requests_, request_port_) = builder.stream<rt::FlyRequest>(group, "FLY", 16, 8);
  outlet_ = builder.outlet<rt::RotorCommand>(group, "rotors");
  pilot_task_ = builder.task<planner::UavPilotOutput>(
      group, "pilot", 50, [this](rt::JobContext& context, planner::UavPilotOutput& output) {
        if (requests_ != nullptr) {
          // A refusal is counted in the output, by its reason.
          for (const rt::FlyRequest& request : *requests_)
            static_cast<void>(pilot_->request(request, context.release_ns));
        }
        if (rt::kBuilt<"join"> && pilot_->wants_place()) take_place();
        const planner::UavWay* way = way_input_ != nullptr ? way_input_->latest() : nullptr;
        pilot_->update(estimator_->state(), way, context.release_ns);
        output = pilot_->output();
        outlet_->put(output.command);
      });
  builder.remembers(pilot_task_, *pilot_);
  add_pilot_counters(builder);
}

void FlightPart::add_pilot_counters(VehicleBuilder& builder) {
  builder.counter("commands_sent", [this] { return commands_sent_; });
  builder.counter("commands_refused", [this] { return commands_refused_; });
  const planner::UavPilotOutput& output = pilot_->output();
  builder.counter("goals_reached", [&output] { return std::uint64_t{output.reached}; });
  builder.counter("goals_without_way", [&output] { return std::uint64_t{output.no_way}; });
  builder.counter("ways_given_up", [&output] { return std::uint64_t{output.replans}; });
  builder.counter("times_without_fixes", [&output] { return std::uint64_t{output.blinded}; });
  builder.counters("flight_", output.control);
  if (requests_ != nullptr) builder.counters("fly_requests_", output.requests);
}

std::unique_ptr<planner::FlightMap> FlightPart::make_flight_map(VehicleBuilder& builder,
                                                                const planner::FlightMapConfig& size) {
  rt::Arena& arena = builder.arena();
  const std::uint32_t bricks = planner::FlightMap::bricks_for(size);
  return std::make_unique<planner::FlightMap>(
      size, arena.make_array<planner::BrickMask>("flight map", bricks),
      arena.make_array<planner::BrickMask>("flight map", bricks),
      arena.make_array<std::uint64_t>("flight map", planner::FlightMap::dirty_words_for(size)));
}

void FlightPart::add_sensing(VehicleBuilder& builder, rt::GroupId group, const planner::FlightMapConfig& size,
                             double bubble_m) {
  const auto asked = [this] {
    const planner::UavPilotOutput* pilot = question_input_->latest();
    return pilot != nullptr && pilot->question.number != 0;
  };
  sensing_ = std::make_unique<UavSensing>(builder, group, asked,
                                          size.radii_m + rt::Vector3{bubble_m, bubble_m, bubble_m});
  if (sensing_->map().config().voxel_size_m != size.voxel_m)
    builder.profile().fail("occupancy.voxel_m",
                           "must be flight_map.voxel_m: voxels are taken from its cells");
  builder.counters("ways_", guide_->counts());
}

// On a stored map the vehicle takes off from where it was set down, seen or not: with a lidar, UavSensing
// does this as it flies.
void FlightPart::clear_start(const VehicleBuilder& builder, const GuideConfig& config) {
  const rt::Vector3 start = rt::to_vector(builder.initial_pose().p_world_body_m);
  const double more = config.bubble_m;
  const rt::Vector3 r = config.map.radii_m + rt::Vector3{more, more, more};
  for (std::int32_t z = 0; z < config.map.nz; ++z) {
    for (std::int32_t y = 0; y < config.map.ny; ++y) {
      for (std::int32_t x = 0; x < config.map.nx; ++x) {
        const rt::Vector3 d = map_->middle_m({x, y, z}) - start;
        const rt::Vector3 s{d.x / r.x, d.y / r.y, d.z / r.z};
        const auto index = static_cast<std::size_t>((z * config.map.ny + y) * config.map.nx + x);
        if (rt::norm(s) <= 1.0 && (config.known.empty() || config.known[index] == CellState::unknown))
          static_cast<void>(map_->set_blocked({x, y, z}, false));  // it lies inside
      }
    }
  }
}

void FlightPart::add_path(VehicleBuilder& builder, rt::GroupId control) {
  GuideConfig config = read_guide_config(builder);
  boxes_ = std::move(config.boxes);
  rt::Arena& arena = builder.arena();
  const std::uint32_t bricks = planner::FlightMap::bricks_for(config.map);
  map_ = make_flight_map(builder, config.map);
  if (rt::kBuilt<"join"> && seeks_) {
    if (config.known.empty())
      builder.profile().fail("flight_map.source",
                             "a vehicle that seeks its place flies by a map of the other robot: choose "
                             "\"stored\", as `sortie export flight_map` writes it");
    known_ = std::move(config.known);
    config.known.clear();
    carried_.emplace(known_, *map_);
  }
  planner::put_known(config.known, *map_);
  if (!seeks_ && !config.sensed && config.map.unknown_is_blocked) clear_start(builder, config);
  const planner::CoarseMemory coarse{arena.make_array<planner::PathNode>("path parts", config.parts),
                                     arena.make_array<std::uint32_t>("path parts", config.parts),
                                     arena.make_array<std::uint32_t>("path parts", bricks)};
  const planner::FineMemory fine{arena.make_array<planner::FineVoxel>("path voxels", config.voxels),
                                 arena.make_array<std::uint32_t>("path voxels", config.voxels),
                                 arena.make_array<planner::VoxelPoint>("path parts", config.parts),
                                 arena.make_array<float>("path parts", config.parts)};
  const planner::CornerMemory corners{arena.make_array<planner::Voxel3>("path corners", config.corners),
                                      arena.make_array<float>("path corners", config.corners),
                                      arena.make_array<std::uint32_t>("path corners", config.corners)};
  if (arena.refused() != 0) builder.profile().fail("limits.path_parts", "the memory is too small");
  path_ = std::make_unique<planner::UavPath>(planner::UavPathMemory{coarse, fine, corners});
  guide_ = std::make_unique<planner::UavGuide>(*map_, *path_, boxes_);
  if (guide_->status() != Status::ok)
    builder.profile().fail("airframe.radius_m", "the vehicle is too large for voxels of this size");
  const rt::GroupId group = way_group_ = builder.group(config.sensed ? "mapping" : "planning", 10);
  question_input_ = builder.input(group, pilot_task_, 1);
  if (rt::kBuilt<"sensed_map"> && config.sensed) {
    planner::FlightMapConfig hope = config.map;
    hope.unknown_is_blocked = false;
    hope_ = make_flight_map(builder, hope);
    planner::put_known(config.known, *hope_);
    guide_->expect(*hope_, config.cells);
    add_sensing(builder, group, config.map, config.bubble_m);
  }
  const rt::Task<planner::UavWay>* task = builder.task<planner::UavWay>(
      group, "path", TaskDefaults{5000, rt::Criticality::b, 100'000},
      [this](rt::JobContext& context, planner::UavWay& output) {
        const planner::UavPilotOutput* pilot = question_input_->latest();
        if (rt::kBuilt<"sensed_map"> && sensing_) guide_->sense(sensing_->map().view());
        // Questions wait until the other robot's map is there.
        if (rt::kBuilt<"join"> && carried_ && carries_map(context)) pilot = nullptr;
        guide_->look(pilot != nullptr ? &pilot->question : nullptr, context.release_ns);
        while (guide_->works() && context.spend(planner::UavGuide::kSlice)) guide_->step();
        output = guide_->way();
      });
  if (rt::kBuilt<"join"> && carried_) {
    builder.remembers(task, *carried_, *guide_);
  } else {
    builder.remembers(task, *guide_);
  }
  way_input_ = builder.input(control, task, 1);
}

// The pilot's goals are on the other robot's map.
void FlightPart::take_place() {
  const JoinOutput* place = place_input_ != nullptr ? place_input_->latest() : nullptr;
  if (place == nullptr || !place->placed) return;
  const rt::Quaternion q_own_map = rt::conjugate(rt::to_quaternion(place->q_map_own));
  // Finite, as any place.
  static_cast<void>(
      pilot_->place(-1.0 * rt::rotate(q_own_map, rt::to_vector(place->p_map_own_m)), q_own_map));
}

// True as long as what the other robot knows is not all in this vehicle's map.
bool FlightPart::carries_map(rt::JobContext& context) {
  if (!carried_->has_begun()) {
    const JoinOutput* place = place_for_way_ != nullptr ? place_for_way_->latest() : nullptr;
    if (place == nullptr || !place->placed) return true;
    carried_->begin(rt::to_vector(place->p_map_own_m), rt::to_quaternion(place->q_map_own));
  }
  if (!carried_->works()) return false;
  while (carried_->works() && context.spend(planner::UavGuide::kSlice)) carried_->step();
  guide_->changed();
  return carried_->works();
}

void FlightPart::poll_devices(const Devices& devices, rt::Nanoseconds now_ns) {
  if (devices.can == nullptr) return;
  rt::RotorCommand command;
  if (outlet_ != nullptr && outlet_->take(now_ns, command)) send_command(*devices.can, command);
}

/// All of a command or a refusal. A number is used once, whether or not its frames went (own_motors.cpp).
void FlightPart::send_command(drivers::CanBus& can, const rt::RotorCommand& command) {
  drivers::CanFrame frames[drivers::kCanRotorFrames];
  bool sent = drivers::encode_rotors(command, command_counter_, frames) == Status::ok;
  if (sent) ++command_counter_;
  for (std::uint32_t f = 0; sent && 3 * f < command.rotors; ++f) sent = can.send(frames[f]) == Status::ok;
  ++(sent ? commands_sent_ : commands_refused_);
}

std::unique_ptr<Part> make_flight(VehicleBuilder& builder) { return std::make_unique<FlightPart>(builder); }

}  // namespace sortie::firmware
