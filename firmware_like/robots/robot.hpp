// SPDX-License-Identifier: BSD-3-Clause
// A robot that is made of parts.
#pragma once

#include <memory>
#include <type_traits>
#include <vector>

#include "drivers/can_codec.hpp"
#include "firmware_like/parts/part.hpp"

namespace sortie::firmware {

/// The parts of part_list.hpp that the profile has, in the order of the list, and their CAN bus: each frame
/// is logged, offered to the parts, and goes into the stream of its kind.
class Robot final : public Vehicle {
 public:
  /// Makes the parts. `core`: a part that this robot has in any case, before all others; or null. Throws
  /// ProfileError.
  using Maker = std::unique_ptr<Part> (*)(VehicleBuilder& builder);
  Robot(VehicleBuilder& builder, Maker core);

  void open_devices() override {
    for (const std::unique_ptr<Part>& part : parts_) part->open_devices();
  }
  void poll_devices(const Devices& devices, rt::Nanoseconds now_ns) override;
  std::optional<MotorsNews> motors_news() const override { return first(&Part::motors_news); }
  RequestEntry<rt::DriveRequest> drive_requests() override { return first(&Part::drive_requests); }
  RequestEntry<rt::FlyRequest> fly_requests() override { return first(&Part::fly_requests); }
  drivers::ScanSink* scan_sink() override { return first(&Part::scan_sink); }
  const rt::Task<rt::PoseEstimate>* pose_task() const override { return first(&Part::pose_task); }
  const rt::Task<rt::AttitudeEstimate>* attitude_task() const override { return first(&Part::attitude_task); }
  const rt::Task<rt::LocatedPose>* located_task() const override { return first(&Part::located_task); }
  void for_each_voxel(const std::function<void(const VoxelOnMap&)>& put) const override {
    for (const std::unique_ptr<Part>& part : parts_) part->for_each_voxel(put);
  }
  std::optional<mapping::OccupancyView> occupancy() const override { return first(&Part::occupancy); }
  const mapping::ScanRegistration* surfels() const override { return first(&Part::surfels); }
  const mapping::TargetStore* targets() const override { return first(&Part::targets); }
  const mapping::ImageStore* images() const override { return first(&Part::images); }
  std::optional<RecognitionView> recognition() const override { return first(&Part::recognition); }
  const mapping::SensedCloud* cloud() const override { return first(&Part::cloud); }
  UnitTrial try_units() const override { return first(&Part::try_units); }

 private:
  void make_parts(VehicleBuilder& builder);
  void take_frame(const drivers::CanFrame& frame, rt::Nanoseconds now_ns);
  void push(drivers::CanSample& sample, rt::Nanoseconds now_ns);
  /// The first answer of a part that is one.
  template <class Ask>
  std::invoke_result_t<Ask, Part&> first(Ask ask) const {
    for (const std::unique_ptr<Part>& part : parts_) {
      if (auto answer = (*part.*ask)()) return answer;
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
