// SPDX-License-Identifier: BSD-3-Clause
// The whole simulated ground vehicle: drive and flipper commands in by CAN, rays to fire by the link of the
// solid-state lidar; IMU, encoders, flippers by CAN, scans and frames of returns out; exact truth.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "drivers/can_bus.hpp"
#include "drivers/scan_source.hpp"
#include "hil/canopen/vehicle_drives.hpp"
#include "hil/imu_truth.hpp"
#include "hil/odrive/vehicle_axes.hpp"
#include "hil/ugv_config.hpp"
#include "rt/sensor_truth.hpp"
#include "rt/status.hpp"

namespace sortie::hil {

/// Counts of the plant, beside those of its parts.
struct UgvCounters {
  std::uint64_t steps{};
  std::uint64_t frames_sent{};
  std::uint64_t frames_refused{};  ///< the port's queue was full or the bus was off
  std::uint64_t commands_taken{};
  std::uint64_t commands_repeated{};  ///< the counter of the one before: a stuck sender, not taken
  std::uint64_t commands_malformed{};
  std::uint64_t flipper_commands{};  ///< taken, one a pair
  std::uint64_t late_steps{};        ///< steps made up for after a call that came late
};

/// The vehicle. About 90 kB, with contacts 200 kB more on the heap: keep it off small stacks. No heap after
/// construction. One thread at a time; the world is its own. Deterministic: equal config and equal received
/// frames give equal sent frames, scans and truth, on every compiler and processor.
class UgvPlant {
 public:
  static constexpr rt::Nanoseconds kStepNs = rt::kNanosecondsPerMillisecond;
  static constexpr int kMaxStepsPerCall = 100;
  static constexpr int kMaxFramesPerStep = 64;

  /// `port` is the vehicle's own node on the bus; `scans` may be null: then there is no lidar; `ssl` may be
  /// null: then there is no solid-state lidar. All must outlive the plant. Throws std::runtime_error naming
  /// the setting if the config is not usable.
  UgvPlant(const UgvConfig& config, drivers::CanBus& port, drivers::ScanSink* scans,
           drivers::SslStub* ssl = nullptr);

  /// Advances plant time in steps of 1 ms to the last whole one not after `now_ns`; usually one step. In each
  /// step: take commands, move, fire the rays of that millisecond, send due IMU and track frames
  /// (stamped with the plant's time). Status: ok; time_repeated (less than one step since the last: nothing
  /// done); time_backwards (the same); stale (more than 100 steps behind: 100 were made, the rest follows at
  /// the next call). Cost: about 15 us a step with the default lidar, of which most is rays.
  Status step(rt::Nanoseconds now_ns);

  /// Exact pose at plant time.
  rt::TruthSample truth() const { return to_truth(body_->motion()); }
  /// What IMU and encoders would have shown without errors, as of the newest IMU sample, sent or lost; stamp
  /// 0 before the first.
  const rt::SensorTruth& sensor_truth() const { return sensor_truth_; }
  /// Contacts and flippers of the last step. False without contacts.
  bool contact_truth(rt::ContactTruth& truth) const { return body_->read_contacts(truth); }
  /// Says what the devices' clock reads at plant time 0: the time counters in the frames count from there.
  /// Before the first step.
  void set_device_clock(rt::Nanoseconds reading_ns) { config_.can.epoch_ns = -reading_ns; }
  /// Exact pose, twist and belt travel at plant time.
  const Motion& motion() const { return body_->motion(); }
  /// Plant time.
  rt::Nanoseconds now_ns() const { return body_->motion().stamp_ns; }

  /// The body; with contacts it is a TrackedBody.
  const VehicleBody& body() const { return *body_; }
  /// The hall that was built; print its seed. Empty with contacts.
  const HallReport& hall() const { return hall_; }
  /// The scene.
  const World& world() const { return world_; }

  const UgvCounters& counters() const { return counters_; }
  RobotCounters robot_counters() const { return body_->counters(); }
  const RangeCounters& lidar_ranges() const {
    return config_.lidar_kind == LidarKind::rows ? lidar_.ranges() : rolling_laser_.ranges();
  }
  const SslSensor& ssl() const { return ssl_; }
  const FaultCounters& imu_faults() const { return imu_faults_.counters(); }
  const FaultCounters& track_faults() const { return track_faults_.counters(); }
  const FaultCounters& command_faults() const { return command_faults_.counters(); }
  /// The drives on CANopen; none unless the config has them.
  VehicleDrives& drives() { return drives_; }
  const VehicleDrives& drives() const { return drives_; }
  /// The same on ODrives.
  VehicleAxes& axes() { return axes_; }
  const VehicleAxes& axes() const { return axes_; }

 private:
  void step_once();
  void note_flippers(double (&flipper_rad)[kFlippers]) const;
  void fire_rays(const SensorStep& step);
  void play_stops();
  void take_commands();
  void send_imu(rt::Nanoseconds since_start_ns);
  void move_ground(const Motion& before, const Motion& after);
  void note_sensor_truth(const InertialTruth& truth);
  void send_tracks(rt::Nanoseconds since_start_ns);
  void send_flippers();
  bool take_flippers(const drivers::CanFrame& frame);
  void send(std::span<const drivers::CanFrame> frames, bool twice);

  UgvConfig config_;
  drivers::CanBus* port_;
  drivers::ScanSink* scans_;
  drivers::SslStub* ssl_link_;
  World world_;
  std::unique_ptr<PlantScene> scene_;  ///< with contacts alone
  HallReport hall_;
  std::unique_ptr<VehicleBody> body_;
  VehicleDrives drives_;
  VehicleAxes axes_;
  StopScript stops_;
  InertialIntegral inertia_;
  ImuModel imu_;
  VehicleShell shell_;
  RayCaster caster_;
  LidarModel lidar_;
  RollingLaser rolling_laser_;
  SslSensor ssl_;
  FaultInjector imu_faults_;
  FaultInjector track_faults_;
  FaultInjector command_faults_;
  rt::Nanoseconds track_period_ns_;
  bool heard_{};
  std::uint8_t last_counter_{};
  double ground_left_m_{};
  double ground_right_m_{};
  rt::SensorTruth sensor_truth_{};
  UgvCounters counters_{};
};

}  // namespace sortie::hil
