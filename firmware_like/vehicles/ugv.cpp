// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/vehicles/ugv.hpp"

#include <tuple>

#include "firmware_like/vehicles/ugv_config.hpp"

namespace sortie::firmware {

namespace {
constexpr double kMovingSpeed_m_s = 0.01;
}  // namespace

Ugv::Ugv(VehicleBuilder& builder) {
  // A scene without any estimator has no control group: a recorded walk with posed scans needs only the map.
  if (builder.wants("attitude")) {
    const rt::GroupId control = builder.group("control", 1000);
    add_attitude(builder, control);
    if (builder.wants("odometry")) {
      add_odometry(builder, control);
      if (builder.wants("drive", false)) add_drive(builder, control);
    }
  }
  if (builder.wants("map", false))
    map_ = std::make_unique<UgvMap>(builder, UgvMap::Sources{odometry_task_, flipper_task_});
  if (builder.wants("ssl", false)) ssl_ = std::make_unique<UgvSsl>(builder);
  if (drive_) builder.chain({"imu_to_drive", {"IMU", "attitude", "odometry", "drive"}});
  if (map_) builder.chain({"scan_to_map", {"SCAN", "map"}});
  builder.check();
}

void Ugv::add_attitude(VehicleBuilder& builder, rt::GroupId group) {
  std::tie(imu_, imu_port_) = builder.stream<rt::ImuSample>(group, "IMU", 256, kImuBatch);
  // The frames of the bus do not say what kind of values they carry: that belongs to the device.
  imu_kind_ = builder.profile().text("imu.samples", "mean",
                                     "what the IMU on the bus sends: means over the interval, or points",
                                     {"mean", "point"}) == "mean"
                  ? rt::kImuMeanRate
                  : 0u;
  attitude_ = std::make_unique<estimators::Attitude>(read_attitude_config(builder));
  track_aid_ = builder.profile().text("attitude.track_aid", "on",
                                      "the tracks' acceleration is taken out of the specific force",
                                      {"on", "off"}) == "on";
  const auto adjust = [&](const char* path, void (estimators::Attitude::*set)(double)) {
    builder.parameter(group, path, [this, set](double value) {
      (attitude_.get()->*set)(value);
      return Status::ok;
    });
  };
  adjust("attitude.acc_time_constant_s", &estimators::Attitude::set_acc_time_constant);
  adjust("attitude.bias_forgetting_s", &estimators::Attitude::set_bias_forgetting);
  attitude_task_ = builder.task<rt::AttitudeEstimate>(
      group, "attitude", 50, [this](rt::JobContext&, rt::AttitudeEstimate& output) {
        job_attitude_count_ = 0;
        // A backward read: the tracks' speed of the job before.
        if (odometry_) {
          const rt::PoseEstimate& pose = odometry_->estimate();
          const double speed = pose.v_body_m_s[0];
          attitude_->set_moving(speed > kMovingSpeed_m_s || speed < -kMovingSpeed_m_s);
          // A speed that is not finite is no aid; the odometry counts what made it so.
          if (track_aid_) static_cast<void>(attitude_->set_track_speed(speed, pose.stamp_ns));
        }
        for (const rt::ImuSample& sample : *imu_) {
          // A refused sample is counted by the filter, by reason.
          if (attitude_->update(sample) == Status::ok)
            job_attitudes_[job_attitude_count_++] = attitude_->estimate();
        }
        output = attitude_->estimate();
      });
  builder.remembers(attitude_task_, *attitude_);
  const estimators::Attitude* attitude = attitude_.get();
  builder.counter("imu_used", [attitude] { return attitude->counters().used; });
  builder.counter("imu_not_finite", [attitude] { return attitude->counters().not_finite; });
  builder.counter("imu_out_of_range", [attitude] { return attitude->counters().out_of_range; });
  builder.counter("imu_time_backwards", [attitude] { return attitude->counters().time_backwards; });
  builder.counter("imu_time_repeated", [attitude] { return attitude->counters().time_repeated; });
  builder.counter("imu_gaps", [attitude] { return attitude->counters().gaps; });
  builder.counter("imu_saturated", [attitude] { return attitude->counters().saturated; });
  builder.counter("imu_zero_rate", [attitude] { return attitude->counters().zero_rate; });
  builder.counter("imu_shortened", [attitude] { return attitude->counters().shortened; });
  builder.counter("imu_aid_refused", [attitude] { return attitude->counters().aid_refused; });
}

void Ugv::add_odometry(VehicleBuilder& builder, rt::GroupId group) {
  std::tie(tracks_, track_port_) = builder.stream<rt::TrackSample>(group, "TRACK", 128, 32);
  odometry_ = std::make_unique<estimators::TrackOdometry>(read_odometry_config(builder));
  builder.parameter(group, "odometry.scale", [this](double value) {
    odometry_->set_scale(value);
    return Status::ok;
  });
  odometry_task_ = builder.task<rt::PoseEstimate>(
      group, "odometry", 50, [this](rt::JobContext&, rt::PoseEstimate& output) {
        // What is refused is counted by the odometry, by reason.
        for (std::uint32_t i = 0; i < job_attitude_count_; ++i)
          static_cast<void>(odometry_->observe(job_attitudes_[i]));
        for (const rt::TrackSample& sample : *tracks_) static_cast<void>(odometry_->update(sample));
        output = odometry_->estimate();
      });
  builder.remembers(odometry_task_, *odometry_);
  const estimators::TrackOdometry* odometry = odometry_.get();
  builder.counter("track_used", [odometry] { return odometry->counters().used; });
  builder.counter("track_not_finite", [odometry] { return odometry->counters().not_finite; });
  builder.counter("track_time_backwards", [odometry] { return odometry->counters().time_backwards; });
  builder.counter("track_jumps", [odometry] { return odometry->counters().jumps; });
  builder.counter("track_slips", [odometry] { return odometry->counters().slips; });
}

void Ugv::take_frame(const drivers::CanFrame& frame, const Devices& devices, rt::Nanoseconds now_ns) {
  if (devices.log != nullptr) {
    std::uint8_t message[drivers::kCanBytes];
    std::size_t size = 0;
    if (drivers::encode(frame, message, size) == Status::ok) {
      devices.log->sample(std::string(drivers::kChannelCan), now_ns, {message, size});
    }
  }
  drivers::CanSample sample;
  if (decoder_.decode(frame, sample) != Status::ok) return;  // counted by the decoder, by reason
  // A full stream counts its refusals.
  if (sample.kind == drivers::CanSampleKind::imu && imu_port_ != nullptr) {
    sample.imu.flags |= imu_kind_;
    static_cast<void>(imu_port_->push(sample.imu, now_ns));
  } else if (sample.kind == drivers::CanSampleKind::track && track_port_ != nullptr) {
    static_cast<void>(track_port_->push(sample.track, now_ns));
  } else if (sample.kind == drivers::CanSampleKind::flipper && flipper_port_ != nullptr) {
    static_cast<void>(flipper_port_->push(sample.flipper, now_ns));
  }
}

void Ugv::poll_devices(const Devices& devices, rt::Nanoseconds now_ns) {
  if (ssl_) ssl_->poll(devices, now_ns);
  if (devices.can == nullptr) return;
  if (devices.device_epoch_ns != device_epoch_ns_) {  // at the first call
    drivers::CanCodecConfig codec;
    codec.epoch_ns = device_epoch_ns_ = devices.device_epoch_ns;
    decoder_ = drivers::CanSampleDecoder(codec);
  }
  drivers::CanFrame frame;
  for (int taken = 0; taken < 256 && devices.can->receive(frame) == Status::ok; ++taken)
    take_frame(frame, devices, now_ns);
  send_commands(*devices.can, now_ns);
}

void Ugv::for_each_voxel(const std::function<void(const VoxelOnMap&)>& put) const {
  if (!map_) return;
  map_->map().for_each_voxel([&put](const MapVoxel& voxel) {
    put({{voxel.p_world_m.x, voxel.p_world_m.y, voxel.p_world_m.z},
         voxel.count,
         voxel.segment,
         {voxel.normal_world.x, voxel.normal_world.y, voxel.normal_world.z}});
  });
}

}  // namespace sortie::firmware
