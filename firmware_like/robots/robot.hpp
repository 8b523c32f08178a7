// SPDX-License-Identifier: BSD-3-Clause
// A robot that is made of parts.
#pragma once

#include <memory>
#include <vector>

#include "drivers/can_codec.hpp"
#include "firmware_like/parts/part.hpp"

namespace sortie::firmware {

/// The parts of part_list.hpp that the profile has, in the order of the list, and their CAN bus: each frame
/// is logged, offered to the parts, and goes into the stream of its kind.
class Robot final : public Vehicle, public UnitTryer {
 public:
  /// Makes the parts. `core`: a part that this robot has in any case, before all others; or null. Throws
  /// ProfileError.
  using Maker = std::unique_ptr<Part> (*)(VehicleBuilder& builder);
  Robot(VehicleBuilder& builder, Maker core);

  void open_devices() override;
  void poll_devices(const Devices& devices, rt::Nanoseconds now_ns) override;
  std::optional<MotorsNews> motors_news() const override;
  RequestEntry<rt::DriveRequest> drive_requests() override;
  RequestEntry<rt::FlyRequest> fly_requests() override;
  drivers::ScanSink* scan_sink() override;
  const rt::Task<rt::PoseEstimate>* pose_task() const override;
  const rt::Task<rt::AttitudeEstimate>* attitude_task() const override;
  const rt::Task<rt::LocatedPose>* located_task() const override;
  void for_each_voxel(const std::function<void(const VoxelOnMap&)>& put) const override;
  std::optional<mapping::OccupancyView> occupancy() const override;
  const mapping::ScanRegistration* surfels() const override;
  const mapping::SensedCloud* cloud() const override;
  UnitTrial try_units() const override;

 private:
  void make_parts(VehicleBuilder& builder);
  void take_frame(const drivers::CanFrame& frame, rt::Nanoseconds now_ns);
  void push(drivers::CanSample& sample, rt::Nanoseconds now_ns);
  /// The first answer of a part that is one.
  template <class Ask>
  auto first(Ask ask) const -> decltype(ask(std::declval<Part&>())) {
    for (const std::unique_ptr<Part>& part : parts_) {
      if (auto answer = ask(*part)) return answer;
    }
    return {};
  }

  std::vector<std::unique_ptr<Part>> parts_;
  // Of the bus; null where nothing in the scene reads that kind.
  drivers::CanSampleDecoder decoder_;
  rt::Nanoseconds device_epoch_ns_{};
  const ImuKind* imu_kind_{};
  InputPort<rt::ImuSample>* imu_{};
  InputPort<rt::TrackSample>* tracks_{};
  InputPort<rt::FlipperSample>* flippers_{};
  InputPort<rt::UavFix>* fixes_{};
};

}  // namespace sortie::firmware
