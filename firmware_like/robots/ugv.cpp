// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/robots/ugv.hpp"

#include <tuple>

#include "firmware_like/robots/ugv_config.hpp"
#include "firmware_like/runtime/live_keys.hpp"

namespace sortie::firmware {

Ugv::Ugv(VehicleBuilder& builder) {
  // A scene without any estimator has no control group: a recorded walk with posed scans needs only the map.
  // What is asked for and not built was refused before.
  const bool wants_attitude = builder.wants("attitude");
  if (rt::kBuilt<rt::Part::attitude> && wants_attitude) {
    const rt::GroupId control = builder.group("control", 1000);
    add_attitude(builder, control);
    const bool wants_odometry = builder.wants("odometry");
    if (rt::kBuilt<rt::Part::odometry> && wants_odometry) {
      add_odometry(builder, control);
      const bool wants_drive = builder.wants("drive", false);
      if (rt::kBuilt<rt::Part::drive> && wants_drive) add_drive(builder, control);
    }
  }
  const bool wants_map = builder.wants("map", false);
  const bool wants_ssl = builder.wants("ssl", false);
  if (wants_map || wants_ssl) {
    const rt::GroupId mapping = builder.group("mapping", 10);
    if (rt::kBuilt<rt::Part::map> && wants_map) {
      add_pose_input(builder, mapping);
      map_ = std::make_unique<UgvMap>(builder, mapping, UgvMap::Sources{pose_input_, flipper_task_});
    }
    if (rt::kBuilt<rt::Part::ssl> && wants_ssl) add_ssl(builder, mapping);
  }
  add_bus_frames(builder);
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
  const estimators::AttitudeConfig config = read_attitude_config(builder);
  const bool in_single =
      builder.profile().text("attitude.precision", "double",
                             "numbers of the attitude filter: double, or float for a board without double",
                             {"double", "float"}) == "float";
  attitude_ = std::make_unique<ChosenAttitude>(config, in_single);
  track_aid_ = builder.profile().text("attitude.track_aid", "on",
                                      "the tracks' acceleration is taken out of the specific force",
                                      {"on", "off"}) == "on";
  live_keys<estimators::AttitudeConfig>(builder, group, "attitude", *attitude_);
  attitude_task_ = builder.task<rt::AttitudeEstimate>(
      group, "attitude", 50, [this](rt::JobContext&, rt::AttitudeEstimate& output) {
        job_attitude_count_ = 0;
        // A backward read: the tracks' velocity of the job before.
        if (rt::kBuilt<rt::Part::odometry> && odometry_) {
          const rt::PoseEstimate& pose = odometry_->estimate();
          // Before its first sample the odometry has nothing to tell. A velocity that is not finite is no
          // aid; the odometry counts what made it so.
          if ((pose.flags & estimators::kPoseStarted) != 0) {
            attitude_->set_moving(odometry_->belts_run());
            if (track_aid_ && odometry_->velocity_known())
              static_cast<void>(attitude_->set_track_velocity(rt::to_vector(pose.v_body_m_s), pose.stamp_ns));
          }
        }
        for (const rt::ImuSample& sample : *imu_) {
          // A refused sample is counted by the filter, by reason.
          if (attitude_->update(sample) != Status::ok) continue;
          job_samples_[job_attitude_count_] = &sample;
          job_attitudes_[job_attitude_count_++] = attitude_->estimate();
        }
        output = attitude_->estimate();
      });
  builder.remembers(attitude_task_, *attitude_);
  const ChosenAttitude* attitude = attitude_.get();
  builder.counter("imu_used", [attitude] { return attitude->counters().used; });
  builder.uses("IMU", [attitude] { return attitude->counters().used; });
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

void Ugv::add_pose_input(VehicleBuilder& builder, rt::GroupId group) {
  // All poses that became visible since the job before; at most a second of them.
  if (odometry_task_ != nullptr && pose_input_ == nullptr)
    pose_input_ = builder.input(group, odometry_task_, 1000);
}

void Ugv::add_ssl(VehicleBuilder& builder, rt::GroupId group) {
  ssl_ = std::make_unique<UgvSsl>(builder);
  if (ssl_->schedules()) add_pose_input(builder, group);
  ssl_->add_tasks(builder, group, {map_ ? map_->lidar() : LidarScans{}, pose_input_});
}

void Ugv::take_frame(const drivers::CanFrame& frame, const Devices& devices, rt::Nanoseconds now_ns) {
  if (devices.log != nullptr) {
    std::uint8_t message[drivers::kCanBytes];
    std::size_t size = 0;
    if (drivers::encode(frame, message, size) == Status::ok) {
      devices.log->sample(std::string(drivers::kChannelCan), now_ns, {message, size});
    }
  }
  if (rt::kBuilt<rt::Part::drive> && drive_ && emergency_.take(frame, now_ns)) return;
  if (motors_ && motors_->take(frame, now_ns)) return;
  drivers::CanSample sample;
  if (decoder_.decode(frame, sample) != Status::ok) return;  // counted by the decoder, by reason
  // A full stream counts its refusals.
  if (sample.kind == drivers::CanSampleKind::imu && imu_port_ != nullptr) {
    sample.imu.flags |= imu_kind_;
    static_cast<void>(imu_port_->push(sample.imu, now_ns));
  } else if (sample.kind == drivers::CanSampleKind::track && track_port_ != nullptr) {
    static_cast<void>(track_port_->push(sample.track, now_ns));
    if (rt::kBuilt<rt::Part::drive>) own_motors_.note_tracks(now_ns);
  } else if (sample.kind == drivers::CanSampleKind::flipper && flipper_port_ != nullptr) {
    static_cast<void>(flipper_port_->push(sample.flipper, now_ns));
  }
}

void Ugv::open_devices() {
  if (rt::kBuilt<rt::Part::drive> && drive_) emergency_.open();
}

void Ugv::poll_devices(const Devices& devices, rt::Nanoseconds now_ns) {
  if (rt::kBuilt<rt::Part::ssl> && ssl_) ssl_->poll(devices, now_ns);
  if (devices.can == nullptr) return;
  if (devices.device_epoch_ns != device_epoch_ns_) {  // at the first call
    drivers::CanCodecConfig codec;
    codec.epoch_ns = device_epoch_ns_ = devices.device_epoch_ns;
    decoder_ = drivers::CanSampleDecoder(codec);
  }
  drivers::CanFrame frame;
  for (int taken = 0; taken < 256 && devices.can->receive(frame) == Status::ok; ++taken)
    take_frame(frame, devices, now_ns);
  if (rt::kBuilt<rt::Part::drive>) send_commands(*devices.can, now_ns);
}

void Ugv::for_each_voxel(const std::function<void(const VoxelOnMap&)>& put) const {
  if (!rt::kBuilt<rt::Part::map> || !map_) return;
  map_->map().for_each_voxel([&put](const MapVoxel& voxel) {
    put({{voxel.p_world_m.x, voxel.p_world_m.y, voxel.p_world_m.z},
         voxel.count,
         voxel.segment,
         {voxel.normal_world.x, voxel.normal_world.y, voxel.normal_world.z}});
  });
}

}  // namespace sortie::firmware
