// SPDX-License-Identifier: BSD-3-Clause
// The order of things in one millisecond of the simulated multirotor.
#include "hil/uav/uav_vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hil/requirement.hpp"
#include "rt/math.hpp"

namespace sortie::hil {
namespace {

constexpr std::uint64_t kImuStream = 0x66696d75;
constexpr std::uint64_t kCommandStream = 0x66636d64;

// Distance of a point from an upright box; 0 inside.
double distance_m(const Solid& box, const Vec3& p) {
  const double dx = p.x - box.center_x_m;
  const double dy = p.y - box.center_y_m;
  const double x = std::max(0.0, std::fabs(box.cos_yaw * dx + box.sin_yaw * dy) - box.half_x_m);
  const double y = std::max(0.0, std::fabs(box.cos_yaw * dy - box.sin_yaw * dx) - box.half_y_m);
  const double z = std::max({0.0, box.bottom_m - p.z, p.z - box.top_m});
  return std::sqrt(x * x + y * y + z * z);
}

Motion motion_of(const MultirotorState& state, rt::Nanoseconds stamp_ns) {
  return {stamp_ns, state.p_world_m, state.q_world_body, state.v_world_m_s, state.w_body_rad_s};
}

}  // namespace

UavVehicle::UavVehicle(const UavVehicleConfig& config, drivers::CanBus& port, drivers::ScanSink* scans)
    : config_(config),
      port_(&port),
      plant_(config.airframe, config.start_m, config.start_yaw_rad),
      imu_(config.imu, config.seed),
      fixes_(config.fixes, config.seed),
      imu_faults_(config.imu_faults, config.seed, kImuStream),
      command_faults_(config.command_faults, config.seed, kCommandStream),
      scans_(config.lidar.rate_hz != 0 || config.camera.rate_hz != 0 ? scans : nullptr),
      lidar_(config.lidar, config.lidar_faults, config.seed, config.start_ns),
      camera_(config.camera, config.camera_faults, config.seed, config.start_ns),
      now_ns_(config.start_ns) {
  if (config.lidar.rate_hz != 0 && config.camera.rate_hz != 0)
    throw std::runtime_error("hil: one sensor delivers scans: lidar or camera");
  if (config.lose_at_s >= 0.0 && config.lost_rotor >= config.airframe.rotors)
    throw std::runtime_error("hil lost_rotor: there is no such rotor");
  for (const TimedSolid& timed : config_.solids) {
    if (timed.solid.kind != SolidKind::box)
      throw std::runtime_error("hil: a flying vehicle meets boxes only");
  }
  for (const Gust& gust : config_.gusts)
    require("gusts", plant_.add_gust(gust) == Status::ok, "at most 8 fit");
  plant_.set_wind(config_.wind_m_s);
  plant_.set_imu_arm({config.imu.lever_arm_m[0], config.imu.lever_arm_m[1], config.imu.lever_arm_m[2]});
  if (config_.dark_to_ns > config_.dark_from_ns)
    fixes_.black_out(config_.start_ns + config_.dark_from_ns, config_.start_ns + config_.dark_to_ns);
  if (scans_ != nullptr) {
    world_ = std::make_unique<World>();
    build_world(0);
  }
  for (int i = 0; i < kRimPoints; ++i) {
    const rt::SinCos at = rt::sincos(6.283185307179586 * static_cast<double>(i) / kRimPoints);
    rim_[i] = {config_.propeller_radius_m * at.cos, config_.propeller_radius_m * at.sin, 0.0};
  }
}

Status UavVehicle::step(rt::Nanoseconds now_ns) {
  if (now_ns < now_ns_) return Status::time_backwards;
  const rt::Nanoseconds due = (now_ns - now_ns_) / kStepNs;
  if (due == 0) return Status::time_repeated;
  const auto steps = due > kMaxStepsPerCall ? kMaxStepsPerCall : static_cast<int>(due);
  for (int i = 0; i < steps; ++i) step_once();
  counters_.late_steps += static_cast<std::uint64_t>(steps - 1);
  return due > kMaxStepsPerCall ? Status::stale : Status::ok;
}

void UavVehicle::step_once() {
  ++counters_.steps;
  take_commands();
  if (config_.lose_at_s >= 0.0 && rt::to_seconds(now_ns_ - config_.start_ns) >= config_.lose_at_s)
    plant_.fail_rotor(config_.lost_rotor);
  const MultirotorState before = plant_.state();
  static_cast<void>(plant_.step(1e-3));  // a step of this length is never refused
  now_ns_ += kStepNs;
  const rt::Nanoseconds since_ns = now_ns_ - config_.start_ns;
  most_tilt_rad_ = std::max(most_tilt_rad_, plant_.tilt_rad());
  look_for_collisions(since_ns);
  if (scans_ != nullptr) fire_sensor(before, since_ns);
  if (since_ns % imu_.period_ns() == 0) send_imu(since_ns);
  send_fixes();
}

// Anew, since a world only grows before it is finished. In place: no heap.
void UavVehicle::build_world(rt::Nanoseconds since_ns) {
  *world_ = World{};
  built_ = 0;
  for (const TimedSolid& timed : config_.solids) {
    if (timed.from_ns > since_ns) continue;
    if (world_->add(timed.solid) != Status::ok) throw std::runtime_error("hil: a box that no world can hold");
    ++built_;
  }
  if (world_->finalize() != Status::ok) throw std::runtime_error("hil: too many large boxes");
}

void UavVehicle::fire_sensor(const MultirotorState& before, rt::Nanoseconds since_ns) {
  std::size_t there = 0;
  for (const TimedSolid& timed : config_.solids) there += timed.from_ns <= since_ns ? 1 : 0;
  if (there != built_) build_world(since_ns);
  SensorStep step;
  step.before = motion_of(before, now_ns_ - kStepNs);
  step.after = motion_of(plant_.state(), now_ns_);
  lidar_.advance(RayCaster(*world_), step, *scans_);
  camera_.advance(RayCaster(*world_), step, *scans_);
}

void UavVehicle::take_commands() {
  drivers::CanFrame frame;
  for (int i = 0; i < kMaxFramesPerStep && port_->receive(frame) == Status::ok; ++i) {
    drivers::CanRotorThird third;
    const Status status = drivers::decode_rotors(frame, third);
    if (status == Status::not_supported) continue;  // another node's frame
    if (status != Status::ok) {
      ++counters_.commands_malformed;
      continue;
    }
    if (command_faults_.next(now_ns_ - config_.start_ns).drop) continue;
    const std::uint32_t part = third.first / 3;
    if (heard_[part] && counter_[part] == third.counter) {
      ++counters_.commands_repeated;
      continue;
    }
    heard_[part] = true;
    counter_[part] = third.counter;
    heard_ns_ = now_ns_;
    ++counters_.commands_taken;
    for (std::uint32_t r = 0; r < 3 && third.first + r <= kMaxSimulatedRotors; ++r)
      asked_rad_s_[third.first + r] = third.enabled ? third.speed_rad_s[r] : 0.0;
    plant_.command(asked_rad_s_);
  }
  if (!heard_[0] || now_ns_ - heard_ns_ <= config_.command_timeout_ns) return;
  ++counters_.command_stale_steps;
  for (double& speed : asked_rad_s_) speed = 0.0;
  plant_.command(asked_rad_s_);
}

void UavVehicle::send_imu(rt::Nanoseconds since_ns) {
  InertialTruth truth = plant_.take_inertial();
  const Fault fault = imu_faults_.next(since_ns);
  if (fault.saturate) truth.gyr_rad_s.x = 2.0 * config_.imu.gyr_range_rad_s;
  rt::ImuSample sample;
  if (!imu_.read(truth, now_ns_, sample) || fault.drop) return;
  drivers::CanFrame frames[2];
  const std::uint16_t counter =
      drivers::can_time_counter(sample.stamp_ns + fault.stamp_offset_ns, config_.can);
  if (drivers::encode_imu(sample, counter, frames) == Status::ok) send(frames, fault.duplicate);
}

MultirotorState UavVehicle::in_own_frame(MultirotorState state) const {
  const Vec3& m = config_.frame_m;
  if (m.x == 0.0 && m.y == 0.0 && m.z == 0.0 && config_.frame_yaw_rad == 0.0) return state;
  const Quat back = from_yaw_pitch_roll(-config_.frame_yaw_rad, 0, 0);
  state.p_world_m = rotate(back, state.p_world_m - m);
  state.v_world_m_s = rotate(back, state.v_world_m_s);
  state.q_world_body = back * state.q_world_body;
  return state;
}

void UavVehicle::send_fixes() {
  fixes_.observe(now_ns_, in_own_frame(plant_.state()));
  rt::UavFix fix;
  while (fixes_.take(now_ns_, fix)) {
    drivers::CanFrame frames[2];
    const std::uint16_t counter = drivers::can_time_counter(fix.stamp_ns, config_.can);
    if (drivers::encode_fix(fix, counter, frames) == Status::ok) send(frames, false);
  }
}

void UavVehicle::look_for_collisions(rt::Nanoseconds since_ns) {
  const MultirotorState& state = plant_.state();
  double gap_m = least_gap_m_;
  bool touches = false;
  const double reach_m = 1.0;  // farther boxes are of no interest
  for (const TimedSolid& timed : config_.solids) {
    if (timed.from_ns > since_ns) continue;
    const double middle_m = distance_m(timed.solid, state.p_world_m);
    if (middle_m > reach_m) continue;
    double nearest_m = middle_m;
    for (std::uint32_t r = 0; r < config_.airframe.rotors; ++r) {
      for (const Vec3& rim : rim_) {
        const Vec3 point =
            state.p_world_m + rotate(state.q_world_body, config_.airframe.rotor[r].place_m + rim);
        nearest_m = std::min(nearest_m, distance_m(timed.solid, point));
      }
    }
    touches = touches || nearest_m <= 0.0;
    gap_m = std::min(gap_m, nearest_m);
  }
  least_gap_m_ = gap_m;
  if (touches) ++counters_.collision_steps;
  if (touches && !touching_) ++counters_.collisions;
  touching_ = touches;
}

void UavVehicle::send(std::span<const drivers::CanFrame> frames, bool twice) {
  for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
    for (const drivers::CanFrame& frame : frames) {
      ++(port_->send(frame) == Status::ok ? counters_.frames_sent : counters_.frames_refused);
    }
  }
}

rt::TruthSample UavVehicle::truth() const {
  return to_truth(motion_of(in_own_frame(plant_.state()), now_ns_));
}

}  // namespace sortie::hil
