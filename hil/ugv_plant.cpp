// SPDX-License-Identifier: BSD-3-Clause
// The order of things in one millisecond of the simulated vehicle.
#include "hil/ugv_plant.hpp"

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

constexpr std::uint64_t kImuStream = 0x666d75;
constexpr std::uint64_t kTrackStream = 0x667472;
constexpr std::uint64_t kCommandStream = 0x66636d;

rt::Nanoseconds checked_period_ns(const EncoderConfig& c) {
  require("encoder", c.resolution_m >= 1e-6, "resolution_m must be at least 0.000001");
  require("encoder", c.rate_hz > 0 && c.rate_hz <= 1000 && 1000 % c.rate_hz == 0, "rate_hz must divide 1000");
  return rt::kNanosecondsPerSecond / static_cast<rt::Nanoseconds>(c.rate_hz);
}

// Only one of the lidars turns.
LidarConfig rows_of(const UgvConfig& config) {
  LidarConfig lidar = config.lidar;
  if (config.lidar_kind != LidarKind::rows) lidar.rate_hz = 0;
  return lidar;
}

RollingLaserConfig rolling_of(const UgvConfig& config) {
  RollingLaserConfig laser = config.rolling_laser;
  if (config.lidar_kind != LidarKind::rotating_2d) laser.line_hz = 0;
  return laser;
}

// Scene, world and body that the config asks for.
std::unique_ptr<PlantScene> make_scene(const UgvConfig& config, World& world) {
  if (!config.contacts) return nullptr;
  auto scene = std::make_unique<PlantScene>();
  build_course(config.course, *scene, world);
  return scene;
}

std::unique_ptr<VehicleBody> make_body(const UgvConfig& config, const World& world, const PlantScene* scene,
                                       rt::Nanoseconds step_ns) {
  if (scene == nullptr)
    return std::make_unique<KinematicRobot>(config.robot, world, config.start_ns, step_ns);
  return std::make_unique<TrackedBody>(config.tracked, *scene, config.start_ns, step_ns);
}

}  // namespace

UgvPlant::UgvPlant(const UgvConfig& config, drivers::CanBus& port, drivers::ScanSink* scans,
                   drivers::SslStub* ssl)
    : config_(config),
      port_(&port),
      scans_(scans),
      ssl_link_(ssl),
      scene_(make_scene(config, world_)),
      hall_(scene_ ? HallReport{} : build_hall(config.hall, world_)),
      body_(make_body(config, world_, scene_.get(), kStepNs)),
      drives_(config.drives, port, config.contacts),
      axes_(config.axes, port, config.contacts),
      stops_(config.stops),
      inertia_({config.imu.lever_arm_m[0], config.imu.lever_arm_m[1], config.imu.lever_arm_m[2]}),
      imu_(config.imu, config.seed),
      shell_(config.tracked.plant.vehicle, config.tracked.height_m),
      caster_(world_, config.self_hits ? &shell_ : nullptr),
      lidar_(rows_of(config), config.lidar_faults, config.seed, config.start_ns),
      rolling_laser_(rolling_of(config), config.lidar_faults, config.seed, config.start_ns),
      ssl_(config.ssl, config.ssl_faults, config.seed, config.start_ns),
      imu_faults_(config.imu_faults, config.seed, kImuStream),
      track_faults_(config.track_faults, config.seed, kTrackStream),
      command_faults_(config.command_faults, config.seed, kCommandStream),
      track_period_ns_(checked_period_ns(config.encoder)) {}

Status UgvPlant::step(rt::Nanoseconds now_ns) {
  if (now_ns < this->now_ns()) return Status::time_backwards;
  const rt::Nanoseconds due = (now_ns - this->now_ns()) / kStepNs;
  if (due == 0) return Status::time_repeated;
  const auto steps = due > kMaxStepsPerCall ? kMaxStepsPerCall : static_cast<int>(due);
  for (int i = 0; i < steps; ++i) step_once();
  counters_.late_steps += static_cast<std::uint64_t>(steps - 1);
  return due > kMaxStepsPerCall ? Status::stale : Status::ok;
}

void UgvPlant::step_once() {
  ++counters_.steps;
  play_stops();
  take_commands();
  SensorStep sensors;
  sensors.before = body_->motion();
  note_flippers(sensors.before_flipper_rad);
  body_->step();
  const Motion& after = body_->motion();
  sensors.after = after;
  note_flippers(sensors.after_flipper_rad);
  inertia_.add(sensors.before, after);
  move_ground(sensors.before, after);
  fire_rays(sensors);
  const rt::Nanoseconds since_start_ns = after.stamp_ns - config_.start_ns;
  if (since_start_ns % imu_.period_ns() == 0) send_imu(since_start_ns);
  if (since_start_ns % track_period_ns_ != 0 || config_.drives.enabled || config_.axes.enabled) return;
  if (!stops_.powered()) return;
  send_tracks(since_start_ns);
  send_flippers();
}

// How far the body went over the middle lines of its tracks; by the mean of the speeds at both ends.
void UgvPlant::move_ground(const Motion& before, const Motion& after) {
  const double side_m =
      scene_ ? config_.tracked.plant.vehicle.track_centre_m.y : 0.5 * config_.robot.track_distance_m;
  const double dt_s = rt::to_seconds(after.stamp_ns - before.stamp_ns);
  const double ahead_m_s = 0.5 * (rotate(conjugate(before.q_world_body), before.v_world_m_s).x +
                                  rotate(conjugate(after.q_world_body), after.v_world_m_s).x);
  const double turn_rad_s = 0.5 * (before.w_body_rad_s.z + after.w_body_rad_s.z);
  ground_left_m_ += dt_s * (ahead_m_s - side_m * turn_rad_s);
  ground_right_m_ += dt_s * (ahead_m_s + side_m * turn_rad_s);
}

void UgvPlant::note_sensor_truth(const InertialTruth& truth) {
  sensor_truth_.stamp_ns = now_ns();
  store(truth.gyr_rad_s, sensor_truth_.gyr_rad_s);
  store(truth.acc_m_s2, sensor_truth_.acc_m_s2);
  store(imu_.gyr_bias_rad_s(), sensor_truth_.gyr_bias_rad_s);
  store(imu_.acc_bias_m_s2(), sensor_truth_.acc_bias_m_s2);
  sensor_truth_.belt_left_m = body_->motion().left_m;
  sensor_truth_.belt_right_m = body_->motion().right_m;
  sensor_truth_.ground_left_m = ground_left_m_;
  sensor_truth_.ground_right_m = ground_right_m_;
}

// A robot without moving flippers holds them where it began.
void UgvPlant::note_flippers(double (&flipper_rad)[kFlippers]) const {
  rt::FlipperSample sample;
  const bool moving = config_.self_hits && body_->read_flippers(sample);
  for (int f = 0; f < kFlippers; ++f)
    flipper_rad[f] = moving ? sample.angle_rad[f] : config_.tracked.plant.start_flipper_rad[f];
}

void UgvPlant::fire_rays(const SensorStep& step) {
  if (scans_ != nullptr) {
    lidar_.advance(caster_, step, *scans_);
    rolling_laser_.advance(caster_, step, *scans_);
  }
  if (ssl_link_ != nullptr) ssl_.advance(caster_, step, *ssl_link_);
}

void UgvPlant::play_stops() {
  const bool was_powered = stops_.powered();
  stops_.step(now_ns() - config_.start_ns, *port_);
  if (stops_.powered() == was_powered) return;
  for (std::size_t i = 0; i < drives_.size(); ++i) drives_.node(i).set_power(stops_.powered());
  for (std::size_t i = 0; i < axes_.size(); ++i) axes_.node(i).set_power(stops_.powered());
}

void UgvPlant::take_commands() {
  drivers::CanFrame frame;
  drives_.show(*body_);
  axes_.show(*body_, now_ns());
  for (int i = 0; i < kMaxFramesPerStep && port_->receive(frame) == Status::ok; ++i) {
    if (config_.drives.enabled) {
      drives_.hear(frame, now_ns());
      continue;
    }
    if (config_.axes.enabled) {
      axes_.hear(frame, now_ns());
      continue;
    }
    rt::DriveCommand command;
    std::uint8_t counter = 0;
    const Status status = drivers::decode_drive(frame, command, counter);
    if (status == Status::not_supported && take_flippers(frame)) continue;
    if (status == Status::not_supported) continue;  // another node's frame
    if (status != Status::ok) {
      ++counters_.commands_malformed;
      continue;
    }
    if (command_faults_.next(now_ns() - config_.start_ns).drop || !stops_.powered()) continue;
    if (heard_ && counter == last_counter_) {
      ++counters_.commands_repeated;
      continue;
    }
    heard_ = true;
    last_counter_ = counter;
    if (body_->set_command(command, now_ns()) == Status::ok) ++counters_.commands_taken;
  }
  drives_.step(*body_, now_ns());
  axes_.step(*body_, now_ns());
}

// True when the frame was for the flippers, good or bad. A lost one does no harm: the next says the same.
bool UgvPlant::take_flippers(const drivers::CanFrame& frame) {
  if (!scene_) return false;  // the robot without forces has none
  drivers::FlipperPairCommand command;
  const Status status = drivers::decode_flippers(frame, command);
  if (status == Status::not_supported) return false;
  if (status != Status::ok) {
    ++counters_.commands_malformed;
  } else if (!command_faults_.next(now_ns() - config_.start_ns).drop && stops_.powered() &&
             body_->set_flippers(command) == Status::ok) {
    ++counters_.flipper_commands;
  }
  return true;
}

void UgvPlant::send_imu(rt::Nanoseconds since_start_ns) {
  const InertialTruth exact = inertia_.take();
  InertialTruth truth = exact;
  const Fault fault = imu_faults_.next(since_start_ns);
  if (fault.saturate) truth.gyr_rad_s.x = 2.0 * config_.imu.gyr_range_rad_s;
  rt::ImuSample sample;
  const bool delivered = imu_.read(truth, now_ns(), sample);
  note_sensor_truth(exact);
  if (!delivered || fault.drop) return;
  drivers::CanFrame frames[2];
  const std::uint16_t counter =
      drivers::can_time_counter(sample.stamp_ns + fault.stamp_offset_ns, config_.can);
  if (drivers::encode_imu(sample, counter, frames) == Status::ok) send(frames, fault.duplicate);
}

void UgvPlant::send_tracks(rt::Nanoseconds since_start_ns) {
  const Fault fault = track_faults_.next(since_start_ns);
  if (fault.drop) return;
  const rt::TrackSample sample = read_encoders(config_.encoder, body_->motion());
  drivers::CanFrame frames[2];
  const std::uint16_t counter =
      drivers::can_time_counter(sample.stamp_ns + fault.stamp_offset_ns, config_.can);
  if (drivers::encode_track(sample, counter, frames) == Status::ok) send(frames, fault.duplicate);
}

void UgvPlant::send_flippers() {
  rt::FlipperSample sample;
  if (!body_->read_flippers(sample)) return;
  drivers::CanFrame frames[rt::kFlippers];
  const std::uint16_t counter = drivers::can_time_counter(sample.stamp_ns, config_.can);
  if (drivers::encode_flipper_state(sample, counter, frames) == Status::ok) send(frames, false);
}

void UgvPlant::send(std::span<const drivers::CanFrame> frames, bool twice) {
  for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
    for (const drivers::CanFrame& frame : frames) {
      ++(port_->send(frame) == Status::ok ? counters_.frames_sent : counters_.frames_refused);
    }
  }
}

}  // namespace sortie::hil
