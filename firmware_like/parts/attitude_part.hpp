// SPDX-License-Identifier: BSD-3-Clause
// Which way is down: the attitude filter as a part of the ground robot.
#pragma once

#include <functional>
#include <span>
#include <variant>

#include "estimators/attitude.hpp"
#include "firmware_like/parts/part.hpp"

namespace sortie::firmware {

/// A filter in double precision, or in single: half of the state, and on a processor without double precision
/// a small part of the time; the same within 0.01 degrees.
class ChosenAttitude {
  using Double = estimators::Attitude;
  using Single = estimators::AttitudeFloat;

 public:
  ChosenAttitude(const estimators::AttitudeConfig& config, bool in_single) : filter_(Double(config)) {
    if (in_single) filter_.emplace<Single>(config);
  }

  /// Gives what `use` makes of the filter, an estimators::BasicAttitude that stays where it is. Costs a
  /// branch; not std::visit, which may throw.
  template <class Use>
  auto with(Use use) {
    if (Single* single = std::get_if<Single>(&filter_)) return use(*single);
    return use(*std::get_if<Double>(&filter_));
  }
  template <class Use>
  auto with(Use use) const {
    if (const Single* single = std::get_if<Single>(&filter_)) return use(*single);
    return use(*std::get_if<Double>(&filter_));
  }

 private:
  std::variant<Double, Single> filter_;
};

/// Reader of [attitude]. Throws ProfileError.
estimators::AttitudeConfig read_attitude_config(VehicleBuilder& builder);

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
