// SPDX-License-Identifier: BSD-3-Clause
// The whole simulated multirotor: commands to its rotors in by CAN; IMU, fixes of its place and scans out;
// exact truth, and what it hit.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/can_codec.hpp"
#include "hil/depth_camera.hpp"
#include "hil/fault_injection.hpp"
#include "hil/imu_model.hpp"
#include "hil/lidar_model.hpp"
#include "hil/solid.hpp"
#include "hil/uav/multirotor_plant.hpp"
#include "hil/uav/pose_source.hpp"

namespace sortie::hil {

/// A solid of the world that is there from a moment on.
struct TimedSolid {
  Solid solid;
  rt::Nanoseconds from_ns{};  ///< since the start
};

/// All settings.
struct UavVehicleConfig {
  std::uint64_t seed{1};
  rt::Nanoseconds start_ns{0};  ///< plant time before the first step
  MultirotorConfig airframe = neo11_plant();
  Vec3 start_m;
  double start_yaw_rad{};
  /// Where the frame of its fixes lies in the world: what the vehicle says of places, and truth(), is in it.
  Vec3 frame_m;
  double frame_yaw_rad{};
  double propeller_radius_m{0.14};
  ImuConfig imu{};
  PoseSourceConfig fixes{};
  rt::Nanoseconds dark_from_ns{};  ///< no fixes from here, since the start ...
  rt::Nanoseconds dark_to_ns{};    ///< ... to here
  FaultConfig imu_faults{};
  FaultConfig command_faults{};
  std::vector<Gust> gusts;  ///< at most MultirotorPlant::kMaxGusts
  Vec3 wind_m_s;
  std::uint32_t lost_rotor{};
  double lose_at_s{-1.0};  ///< negative: none is lost
  std::vector<TimedSolid> solids;
  LidarConfig lidar{.rate_hz = 0};  ///< sees the solids, not the vehicle itself
  FaultConfig lidar_faults{};
  DepthCameraConfig camera{.rate_hz = 0};  ///< in place of the lidar: not both
  FaultConfig camera_faults{};
  rt::Nanoseconds command_timeout_ns{100 * rt::kNanosecondsPerMillisecond};  ///< then the rotors stop
  drivers::CanCodecConfig can{};
};

/// Counts of the plant.
struct UavVehicleCounters {
  std::uint64_t steps{};
  std::uint64_t frames_sent{};
  std::uint64_t frames_refused{};
  std::uint64_t commands_taken{};  ///< thirds of them
  std::uint64_t commands_repeated{};
  std::uint64_t commands_malformed{};
  std::uint64_t command_stale_steps{};  ///< rotors stopped for want of commands, after the first
  std::uint64_t collisions{};           ///< times that it came to touch a solid
  std::uint64_t collision_steps{};
  std::uint64_t late_steps{};
};

/// The vehicle. It flies on through what it hits: that is counted, and never right. No heap after
/// construction. Deterministic: equal config and equal received frames give equal sent frames and truth, on
/// every compiler and processor.
class UavVehicle {
 public:
  static constexpr rt::Nanoseconds kStepNs = rt::kNanosecondsPerMillisecond;
  static constexpr int kMaxStepsPerCall = 100;
  static constexpr int kMaxFramesPerStep = 64;
  static constexpr int kRimPoints = 12;

  /// `port` is the vehicle's own node on the bus and outlives it, as `scans` does, where its sensor delivers;
  /// null: nobody takes scans. Throws std::runtime_error naming the
  /// setting if the config is not usable, as one with lidar and camera is not.
  UavVehicle(const UavVehicleConfig& config, drivers::CanBus& port, drivers::ScanSink* scans = nullptr);

  /// Advances plant time in steps of 1 ms to the last whole one not after `now_ns`. Status as
  /// UgvPlant::step. About 3 us a step, and 10 ns a solid.
  Status step(rt::Nanoseconds now_ns);

  /// In the frame of its fixes.
  rt::TruthSample truth() const;
  const MultirotorPlant& plant() const { return plant_; }
  rt::Nanoseconds now_ns() const { return now_ns_; }
  void set_device_clock(rt::Nanoseconds reading_ns) { config_.can.epoch_ns = -reading_ns; }
  /// Least distance of the rotors' rims and hubs from all solids so far; 0 once it touched one.
  double least_gap_m() const { return least_gap_m_; }
  /// Greatest tilt so far.
  double most_tilt_rad() const { return most_tilt_rad_; }
  const UavVehicleCounters& counters() const { return counters_; }
  const FaultCounters& imu_faults() const { return imu_faults_.counters(); }
  const LidarCounters& lidar() const { return lidar_.counters(); }
  const LidarCounters& camera() const { return camera_.counters(); }
  std::uint64_t fixes_lost() const { return fixes_.lost(); }

 private:
  MultirotorState in_own_frame(MultirotorState state) const;
  void step_once();
  void take_commands();
  void send_imu(rt::Nanoseconds since_ns);
  void send_fixes();
  void look_for_collisions(rt::Nanoseconds since_ns);
  void build_world(rt::Nanoseconds since_ns);
  void fire_sensor(const MultirotorState& before, rt::Nanoseconds since_ns);
  void send(std::span<const drivers::CanFrame> frames, bool twice);

  UavVehicleConfig config_;
  drivers::CanBus* port_;
  MultirotorPlant plant_;
  ImuModel imu_;
  PoseSource fixes_;
  FaultInjector imu_faults_;
  FaultInjector command_faults_;
  drivers::ScanSink* scans_;
  std::unique_ptr<World> world_;  ///< what the sensor sees; only where somebody takes scans
  std::size_t built_{};           ///< solids that are in it
  LidarModel lidar_;
  DepthCamera camera_;
  rt::Nanoseconds now_ns_;
  rt::Nanoseconds heard_ns_{};
  bool heard_[drivers::kCanRotorFrames]{};
  std::uint8_t counter_[drivers::kCanRotorFrames]{};
  double asked_rad_s_[kMaxSimulatedRotors + 1]{};
  double least_gap_m_{1e9};
  double most_tilt_rad_{};
  bool touching_{};
  Vec3 rim_[kRimPoints];
  UavVehicleCounters counters_{};
};

}  // namespace sortie::hil
