// SPDX-License-Identifier: BSD-3-Clause
// Which way is down: the attitude filter as a part of the ground robot.
#pragma once

#include <functional>
#include <span>

#include "firmware_like/parts/chosen_attitude.hpp"
#include "firmware_like/parts/part.hpp"

namespace sortie::firmware {

/// Group `control`, task `attitude`: every waiting sample of the IMU goes into the filter. Parts of the same
/// group read what one job made of each sample.
class AttitudePart final : public Part {
 public:
  /// One attitude of the present job, and the sample that led to it.
  struct Step {
    rt::AttitudeEstimate attitude;
    const rt::ImuSample* sample{};
  };
  /// Tells the filter at the beginning of each job what the job before knew; no heap, no lock.
  using Aid = std::function<void(ChosenAttitude& filter)>;

  explicit AttitudePart(VehicleBuilder& builder);

  rt::GroupId group() const { return group_; }
  const rt::Stream<rt::ImuSample>& imu() const { return *imu_; }
  const ChosenAttitude& filter() const { return filter_; }
  /// Of the present job, in order.
  std::span<const Step> steps() const { return {steps_, step_count_}; }
  /// The profile lets the tracks' velocity into the filter.
  bool wants_track_aid() const { return track_aid_; }
  void set_aid(Aid aid) { aid_ = std::move(aid); }

  const rt::Task<rt::AttitudeEstimate>* attitude_task() const override { return task_; }
  void finish(VehicleBuilder& builder) override;

 private:
  static constexpr std::uint32_t kBatch = 64;
  rt::GroupId group_;
  rt::Stream<rt::ImuSample>* imu_{};
  ImuKind kind_;
  ChosenAttitude filter_;
  bool track_aid_{};
  Aid aid_;
  rt::Task<rt::AttitudeEstimate>* task_{};
  Step steps_[kBatch]{};
  std::uint32_t step_count_{};
};

}  // namespace sortie::firmware
