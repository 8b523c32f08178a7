// SPDX-License-Identifier: BSD-3-Clause
// Samples and commands to frames, and a command back: the side of the codec that keeps no state.
#include <cmath>

#include "drivers/can_codec.hpp"
#include "drivers/can_raw.hpp"

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kDriveEnabled = 1u;

CanFrame encode_axes(std::uint32_t id, const CanSignal* fields, const double* axes, rt::Nanoseconds stamp_ns,
                     std::uint16_t counter) {
  CanFrame frame = blank(id, stamp_ns);
  for (int i = 0; i < 3; ++i) write_can_field(frame, fields[i], to_axis(axes[i], fields[i].scale));
  write_can_field(frame, fields[3], counter);
  return frame;
}

bool finite3(const double* v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

}  // namespace

std::uint16_t can_time_counter(rt::Nanoseconds stamp_ns, const CanCodecConfig& config) {
  return CanCounterClock(config.epoch_ns, config.max_age_ns, config.max_ahead_ns).counter(stamp_ns);
}

Status encode_imu(const rt::ImuSample& sample, std::uint16_t counter, CanFrame out[2]) noexcept {
  if (!finite3(sample.gyr_rad_s) || !finite3(sample.acc_m_s2)) return Status::not_finite;
  out[0] = encode_axes(kCanImuGyrId, kCanImuGyrFields, sample.gyr_rad_s, sample.stamp_ns, counter);
  out[1] = encode_axes(kCanImuAccId, kCanImuAccFields, sample.acc_m_s2, sample.stamp_ns, counter);
  return Status::ok;
}

Status encode_track(const rt::TrackSample& sample, std::uint16_t counter, CanFrame out[2]) noexcept {
  if (!std::isfinite(sample.left_m) || !std::isfinite(sample.right_m)) return Status::not_finite;
  constexpr double kLimitM = 9.0e15 * kCanTrackMetresPerCount;
  if (std::fabs(sample.left_m) > kLimitM || std::fabs(sample.right_m) > kLimitM) return Status::out_of_range;
  out[0] = blank(kCanTrackLeftId, sample.stamp_ns);
  out[1] = blank(kCanTrackRightId, sample.stamp_ns);
  write_can_field(out[0], kCanTrackLeftFields[0], to_raw(sample.left_m, kCanTrackLeftFields[0].scale));
  write_can_field(out[1], kCanTrackRightFields[0], to_raw(sample.right_m, kCanTrackRightFields[0].scale));
  write_can_field(out[0], kCanTrackLeftFields[1], counter);
  write_can_field(out[1], kCanTrackRightFields[1], counter);
  return Status::ok;
}

Status encode_drive(const rt::DriveCommand& command, std::uint8_t counter, CanFrame& out) noexcept {
  if (!std::isfinite(command.left_m_s) || !std::isfinite(command.right_m_s)) return Status::not_finite;
  const double limit = static_cast<double>(kCanAxisLimit) * kCanDriveFields[0].scale;
  if (std::fabs(command.left_m_s) > limit || std::fabs(command.right_m_s) > limit)
    return Status::out_of_range;
  out = blank(kCanDriveId, command.stamp_ns);
  write_can_field(out, kCanDriveFields[0], to_raw(command.left_m_s, kCanDriveFields[0].scale));
  write_can_field(out, kCanDriveFields[1], to_raw(command.right_m_s, kCanDriveFields[1].scale));
  write_can_field(out, kCanDriveFields[2], counter);
  write_can_field(out, kCanDriveFields[3], command.flags & kDriveEnabled);
  return Status::ok;
}

Status decode_drive(const CanFrame& frame, rt::DriveCommand& command, std::uint8_t& counter) noexcept {
  if (frame.id != kCanDriveId || frame.flags != 0) return Status::not_supported;
  if (frame.size != find_can_frame(kCanDriveId)->size) return Status::malformed;
  const std::int64_t flags = read_can_field(frame, kCanDriveFields[3]);
  if (flags > kDriveEnabled) return Status::malformed;
  command = {};
  command.stamp_ns = frame.stamp_ns;
  command.left_m_s = physical_can_field(frame, kCanDriveFields[0]);
  command.right_m_s = physical_can_field(frame, kCanDriveFields[1]);
  command.flags = static_cast<std::uint32_t>(flags);
  counter = static_cast<std::uint8_t>(read_can_field(frame, kCanDriveFields[2]));
  return Status::ok;
}

}  // namespace sortie::drivers
