// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/attitude_part.hpp"

#include "drivers/can_frames.hpp"
#include "firmware_like/parts/own_frames.hpp"
#include "firmware_like/runtime/live_keys.hpp"

namespace sortie::firmware {

namespace {

ImuKind read_imu_kind(Profile& profile) {
  const bool mean =
      profile.text("imu.samples", "mean", "what the IMU on the bus sends: means over the interval, or points",
                   {"mean", "point"}) == "mean";
  return {mean ? rt::kImuMeanRate : 0u};
}

ChosenAttitude read_filter(VehicleBuilder& builder) {
  const estimators::AttitudeConfig config = read_attitude_config(builder);
  return {config, builder.profile().text(
                      "attitude.precision", "double",
                      "numbers of the attitude filter: double, or float for a board without double",
                      {"double", "float"}) == "float"};
}

}  // namespace

estimators::AttitudeConfig read_attitude_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  for (const char* path :
       {"groups.control.rate_hz", "imu.samples", "attitude.precision", "attitude.track_aid"})
    profile.knob(path);
  estimators::AttitudeConfig config;
  for (int i = 0; i < 4; ++i) config.q_world_body[i] = builder.initial_pose().q_world_body[i];
  profile.read("attitude", config);
  return config;
}

AttitudePart::AttitudePart(VehicleBuilder& builder)
    : group_(builder.group("control", 1000)),
      imu_(builder.stream<rt::ImuSample>(group_, "IMU", 256, kBatch).first),
      kind_(read_imu_kind(builder.profile())),
      filter_(read_filter(builder)),
      track_aid_(builder.profile().text("attitude.track_aid", "on",
                                        "the tracks' acceleration is taken out of the specific force",
                                        {"on", "off"}) == "on") {
  builder.offer(*this);
  builder.offer(kind_);
  filter_.with([this, &builder](auto& filter) {
    live_keys<estimators::AttitudeConfig>(builder, group_, "attitude", filter);
    task_ = builder.task<rt::AttitudeEstimate>(
        group_, "attitude", 50, [this, &filter](rt::JobContext&, rt::AttitudeEstimate& output) {
          step_count_ = 0;
          if (aid_) aid_(filter_);
          for (const rt::ImuSample& sample : *imu_) {
            // A refused sample is counted by the filter, by reason.
            if (filter.update(sample) != Status::ok) continue;
            steps_[step_count_++] = {filter.estimate(), &sample};
          }
          output = filter.estimate();
        });
    builder.remembers(task_, filter);
    builder.counters("imu_", filter.counters());
    builder.uses("IMU", [&filter] { return filter.counters().used; });
  });
}

void AttitudePart::finish(VehicleBuilder& builder) {
  const std::uint32_t imu[] = {drivers::kCanImuGyrId, drivers::kCanImuAccId};
  add_device_frames(builder, imu, "can.imu_hz", 200, "how often the IMU sends");
}

std::unique_ptr<Part> make_attitude(VehicleBuilder& builder) {
  return std::make_unique<AttitudePart>(builder);
}

}  // namespace sortie::firmware
