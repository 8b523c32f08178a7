// SPDX-License-Identifier: BSD-3-Clause
// A vehicle: what it is asked for from outside.
#pragma once

#include <functional>
#include <optional>

#include "firmware_like/runtime/unit_trial.hpp"
#include "firmware_like/runtime/vehicle_builder.hpp"
#include "mapping/occupancy/occupancy_view.hpp"
#include "planner/request_gate.hpp"
#include "rt/located_pose.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::drivers {
class CanBus;
class SslPort;
}  // namespace sortie::drivers

namespace sortie::mapping {
class ImageStore;
class Recogniser;
class ScanRegistration;
struct SensedCloud;
struct SetHypothesis;
class TargetStore;
}  // namespace sortie::mapping

namespace sortie::firmware {

/// What a vehicle's devices are reached by. Members that a vehicle does not use stay null.
struct Devices {
  drivers::CanBus* can{};
  drivers::SslPort* ssl{};
  /// Writes a CAN frame or a command to the log, if one is kept.
  SampleSink* log{};
  /// When the time counters of the devices were 0, on the run's clock: they count CLOCK_MONOTONIC on a robot,
  /// the run's clock where the devices are simulated beside it.
  rt::Nanoseconds device_epoch_ns{};
};

/// Where requests to a vehicle go in, and what it allows.
template <class Request>
struct RequestEntry {
  InputPort<Request>* port{};  ///< null: the vehicle takes none
  planner::RequestRules rules;
  explicit operator bool() const { return port != nullptr; }
};

/// A voxel of a vehicle's map.
struct VoxelOnMap {
  double p_world_m[3]{};     ///< mean of its points
  std::uint32_t count{};     ///< of points in that mean
  std::uint32_t segment{};   ///< its segment's id; 0: of none
  double normal_world[3]{};  ///< unit vector, its sign means nothing; zero: none
};

/// What the newest answer of recognition rests on, for who shows it: true from the job that gave it up to the
/// task's next one.
struct RecognitionView {
  std::uint64_t answers{};                  ///< since the run, or the replay's keyframe, began
  const mapping::TargetStore* known{};      ///< that places are recognised on
  const mapping::Recogniser* recogniser{};  ///< its segments and pairs
  const mapping::SetHypothesis* best{};     ///< which pairs speak for the answer's place; of none: no set
};

/// How a vehicle's motors are, for who shows it.
struct MotorsNews {
  bool emergency{};             ///< an emergency stop is pressed, by whatever input
  bool running{};               ///< all drives run; motors on the robot's own frames do not tell
  std::uint32_t stop_reason{};  ///< drivers::StopReason; of the robot's own frames none
};

/// A vehicle. Build it in the constructor from a VehicleBuilder; the object lives as long as the runtime.
class Vehicle {
 public:
  virtual ~Vehicle() = default;
  /// On a robot, before the first poll: opens what the operating system has to give. Never in a replay or
  /// beside a simulated robot. May allocate and block. Throws std::runtime_error with the cure.
  virtual void open_devices() {}
  /// Live and simulated runs, on the I/O thread, about every millisecond: read devices into the ports, write
  /// commands. `now_ns`: the run's clock. Never called in a replay.
  virtual void poll_devices(const Devices& /*devices*/, rt::Nanoseconds /*now_ns*/) {}
  /// Motors as of the last poll, from any thread; nothing where there are none.
  virtual std::optional<MotorsNews> motors_news() const { return {}; }
  /// Where requests from outside go in (drivers/wire_requests.hpp), if the profile lets them.
  virtual RequestEntry<rt::DriveRequest> drive_requests() { return {}; }
  /// The same for a vehicle that flies (drivers/wire_requests.hpp).
  virtual RequestEntry<rt::FlyRequest> fly_requests() { return {}; }
  /// Where a lidar driver delivers, or null.
  virtual drivers::ScanSink* scan_sink() { return nullptr; }
  /// The task whose output is the robot's pose, or null: errors and trajectories come from it.
  virtual const rt::Task<rt::PoseEstimate>* pose_task() const { return nullptr; }
  /// The task whose output is the attitude, judged when there is no pose.
  virtual const rt::Task<rt::AttitudeEstimate>* attitude_task() const { return nullptr; }
  /// The task whose output is the place on a map that the robot makes, or null: it is judged by itself.
  virtual const rt::Task<rt::LocatedPose>* located_task() const { return nullptr; }
  /// Calls `put` for every voxel of the map at the end of a run, in no order. Without a map: nothing.
  virtual void for_each_voxel(const std::function<void(const VoxelOnMap&)>& /*put*/) const {}
  /// The occupancy map as it is when no job runs; nothing without one.
  virtual std::optional<mapping::OccupancyView> occupancy() const { return {}; }
  /// The map of surfaces as it is when no job runs; null without one.
  virtual const mapping::ScanRegistration* surfels() const { return nullptr; }
  /// The segments to be recognised as they are when no job runs; null without any.
  virtual const mapping::TargetStore* targets() const { return nullptr; }
  /// The height images to be recognised as they are when no job runs; null without any.
  virtual const mapping::ImageStore* images() const { return nullptr; }
  /// Recognition as it is when no job runs; nothing where no targets are known.
  virtual std::optional<RecognitionView> recognition() const { return {}; }
  /// The cloud as it is when no job runs; null without one.
  virtual const mapping::SensedCloud* cloud() const { return nullptr; }
  /// At the boot of a live run: what a unit of an anytime task takes here; of no task where none is tried.
  virtual UnitTrial try_units() const { return {}; }
};

}  // namespace sortie::firmware
