// SPDX-License-Identifier: BSD-3-Clause
// What every multirotor has: IMU, fixes and requests in; state, ways through the map, rotor commands out.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "estimators/uav_state/uav_estimator.hpp"
#include "firmware_like/parts/join_output.hpp"
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/uav_config.hpp"
#include "firmware_like/parts/uav_sensing.hpp"
#include "firmware_like/runtime/owned_part.hpp"
#include "planner/uav_guide.hpp"
#include "planner/uav_path/carried_map.hpp"
#include "planner/uav_pilot.hpp"

namespace sortie::firmware {

/// Group `control`: state -> pose -> pilot, hop-free; group `planning`: path; where the map is sensed, group
/// `mapping`: occupancy -> path. Without the path task the pilot flies straight to its goals.
class FlightPart final : public Part {
 public:
  explicit FlightPart(VehicleBuilder& builder);

  void finish(VehicleBuilder& builder) override;
  void poll_devices(const Devices& devices, rt::Nanoseconds now_ns) override;
  RequestEntry<rt::FlyRequest> fly_requests() override { return {request_port_, request_rules_}; }
  drivers::ScanSink* scan_sink() override {
    return rt::kBuilt<"sensed_map"> && sensing_ ? sensing_->scan_sink() : nullptr;
  }
  const rt::Task<rt::PoseEstimate>* pose_task() const override { return pose_task_; }
  std::optional<mapping::OccupancyView> occupancy() const override {
    return rt::kBuilt<"sensed_map"> && sensing_ ? std::optional(sensing_->map().view()) : std::nullopt;
  }

 private:
  void add_state(VehicleBuilder& builder, rt::GroupId group);
  void make_pilot(VehicleBuilder& builder, rt::GroupId group);
  void add_pilot(VehicleBuilder& builder, rt::GroupId group);
  void add_path(VehicleBuilder& builder, rt::GroupId control);
  void clear_start(const VehicleBuilder& builder, const GuideConfig& config);
  void add_sensing(VehicleBuilder& builder, rt::GroupId group, const planner::FlightMapConfig& size,
                   double bubble_m);
  bool carries_map(rt::JobContext& context);
  void take_place();
  std::unique_ptr<planner::FlightMap> make_flight_map(VehicleBuilder& builder,
                                                      const planner::FlightMapConfig& size);
  void add_pilot_counters(VehicleBuilder& builder);
  void put_pose(rt::PoseEstimate& pose);
  void send_command(drivers::CanBus& can, const rt::RotorCommand& command);

  rt::GroupId control_;
  // Inputs.
  rt::Stream<rt::ImuSample>* imu_{};
  rt::Stream<rt::UavFix>* fixes_{};
  rt::Stream<rt::FlyRequest>* requests_{};
  InputPort<rt::FlyRequest>* request_port_{};
  planner::RequestRules request_rules_;
  // Algorithms; null where the scene leaves them out.
  std::unique_ptr<estimators::UavEstimator> estimator_;
  std::unique_ptr<planner::UavPilot> pilot_;
  std::vector<planner::KnownBox> boxes_;
  bool seeks_{};                           // its place on another robot's map, before its mission
  std::vector<planner::CellState> known_;  // of that map; empty: nothing
  std::optional<planner::CarriedMap> carried_;
  rt::GroupId way_group_;
  std::unique_ptr<planner::FlightMap> map_;
  std::unique_ptr<planner::FlightMap> hope_;     // only where the map is sensed
  OwnedPart<UavSensing, "sensed_map"> sensing_;  // the same
  std::unique_ptr<planner::UavPath> path_;
  std::unique_ptr<planner::UavGuide> guide_;
  // Tasks and what crosses groups.
  rt::Task<rt::PoseEstimate>* pose_task_{};
  rt::Task<planner::UavPilotOutput>* pilot_task_{};
  rt::Input<planner::UavPilotOutput>* question_input_{};
  rt::Input<planner::UavWay>* way_input_{};
  rt::Input<JoinOutput>* place_input_{};    // of the pilot; null unless it seeks
  rt::Input<JoinOutput>* place_for_way_{};  // of the path
  rt::CommandOutlet<rt::RotorCommand>* outlet_{};
  double distance_m_{};
  rt::Vector3 last_m_;
  bool located_{};
  // Devices.
  ImuKind imu_kind_{rt::kImuMeanRate};
  std::uint8_t command_counter_{};
  std::uint32_t rotor_count_{};
  std::uint64_t commands_sent_{};
  std::uint64_t commands_refused_{};
};

/// The core of the robot "uav". Set-up only; throws ProfileError.
std::unique_ptr<Part> make_flight(VehicleBuilder& builder);

}  // namespace sortie::firmware
