// SPDX-License-Identifier: BSD-3-Clause
// Frames to samples: what the sensors send, pair by pair, trusting nothing.
#include "drivers/can_codec.hpp"

#include <stdexcept>

namespace sortie::drivers {

namespace {

bool decode_axes(const CanFrame& frame, const CanSignal* fields, double* axes) {
  bool clipped = false;
  for (int i = 0; i < 3; ++i) {
    const std::int64_t raw = read_can_field(frame, fields[i]);
    axes[i] = static_cast<double>(raw) * fields[i].scale;
    clipped = clipped || raw >= kCanAxisLimit || raw <= -kCanAxisLimit;
  }
  return clipped;
}

Status tallied(std::uint64_t& counter, Status status) {
  ++counter;
  return status;
}

}  // namespace

CanSampleDecoder::CanSampleDecoder(const CanCodecConfig& config)
    : clock_(config.epoch_ns, config.max_age_ns, config.max_ahead_ns) {
  if (config.max_age_ns < 0 || config.max_age_ns > 6 * rt::kNanosecondsPerSecond || config.max_ahead_ns < 0 ||
      config.max_ahead_ns > rt::kNanosecondsPerSecond / 2) {
    throw std::runtime_error(
        "CAN codec: max_age_ns must lie in 0..6 s and max_ahead_ns in 0..0.5 s (the time counter wraps at "
        "6.5 s)");
  }
  if (config.epoch_ns < -(rt::Nanoseconds{1} << 61) || config.epoch_ns > (rt::Nanoseconds{1} << 61)) {
    throw std::runtime_error(
        "CAN codec: epoch_ns is beyond +-73 years; give it in ns of the bus stamps' clock");
  }
  if (!(config.max_track_m_s > 0.0) || config.max_track_m_s > 1000.0) {
    throw std::runtime_error("CAN codec: max_track_m_s must lie in (0, 1000] m/s");
  }
  max_counts_per_s_ = static_cast<std::int64_t>(config.max_track_m_s / kCanTrackMetresPerCount);
}

Status CanSampleDecoder::decode(const CanFrame& frame, CanSample& out) noexcept {
  out.kind = CanSampleKind::none;
  ++counters_.frames;
  if ((frame.flags & kCanError) != 0) return tallied(counters_.error_frames, Status::not_supported);
  const CanMessage* spec = (frame.flags & kCanExtended) != 0 ? nullptr : find_can_frame(frame.id);
  if (spec == nullptr) return tallied(counters_.unknown_id, Status::not_supported);
  if ((frame.flags & kCanRemote) != 0) return tallied(counters_.remote_frames, Status::not_supported);
  if (frame.size != spec->size || frame.flags != 0) return tallied(counters_.wrong_size, Status::malformed);
  if (spec->id == kCanDriveId) return tallied(counters_.drive_frames, Status::ok);
  if (spec->id == kCanFlipperFrontId || spec->id == kCanFlipperRearId)
    return tallied(counters_.flipper_frames, Status::ok);
  if (spec->id >= kCanRotorsId && spec->id < kCanRotorsId + kCanRotorFrames)
    return tallied(counters_.rotor_frames, Status::ok);
  if (spec->id >= kCanFlipperStateId && spec->id < kCanFlipperStateId + 4) return join_flipper(frame, out);
  const bool is_imu = spec->id == kCanImuGyrId || spec->id == kCanImuAccId;
  const bool is_fix = spec->id == kCanFixAcrossId || spec->id == kCanFixUpId;
  const bool second = spec->id == kCanImuAccId || spec->id == kCanTrackRightId || spec->id == kCanFixUpId;
  Pair& pair = is_imu ? imu_ : is_fix ? fix_ : track_;
  const CanFrame first_half = pair.half;
  bool complete = false;
  const Status joined = join(pair, frame, second, spec->fields[spec->field_count - 1], complete);
  if (joined != Status::ok || !complete) return joined;
  if (const Status order = check_order(pair); order != Status::ok) return order;
  const CanFrame& first = second ? first_half : frame;
  const CanFrame& last = second ? frame : first_half;
  const Status given = is_fix   ? finish_fix(first, last, out)
                       : is_imu ? finish_imu(first, last, out)
                                : finish_track(first, last, out);
  if (given != Status::ok) return given;
  pair.given = true;
  pair.last_ns = pair.stamp_ns;
  return Status::ok;
}

Status CanSampleDecoder::join(Pair& pair, const CanFrame& frame, bool second, const CanSignal& time,
                              bool& complete) {
  rt::Nanoseconds stamp_ns = 0;
  const auto counter = static_cast<std::uint16_t>(read_can_field(frame, time));
  const Status timed = clock_.unwrap(counter, frame.stamp_ns, stamp_ns);
  if (timed != Status::ok) return tallied(counters_.out_of_time, timed);
  if (pair.waiting && pair.second != second && pair.stamp_ns == stamp_ns) {
    pair.waiting = false;
    complete = true;
    return Status::ok;
  }
  if (pair.waiting) ++counters_.missing_partner;
  pair.waiting = true;
  pair.second = second;
  pair.stamp_ns = stamp_ns;
  pair.half = frame;
  return Status::ok;
}

Status CanSampleDecoder::join_flipper(const CanFrame& frame, CanSample& out) {
  rt::Nanoseconds stamp_ns = 0;
  const auto counter = static_cast<std::uint16_t>(read_can_field(frame, kCanFlipperStateFields[2]));
  const Status timed = clock_.unwrap(counter, frame.stamp_ns, stamp_ns);
  if (timed != Status::ok) return tallied(counters_.out_of_time, timed);
  bool complete = false;
  counters_.missing_partner +=
      flippers_.add(frame.id - kCanFlipperStateId, stamp_ns,
                    static_cast<std::int16_t>(read_can_field(frame, kCanFlipperStateFields[0])),
                    static_cast<std::int16_t>(read_can_field(frame, kCanFlipperStateFields[1])), complete);
  if (!complete) return Status::ok;
  const Status order = flippers_.take(out.flipper);
  if (order != Status::ok) return tallied(counters_.flipper_order, order);
  ++counters_.flipper_samples;
  out.kind = CanSampleKind::flipper;
  return Status::ok;
}

Status CanSampleDecoder::check_order(Pair& pair) {
  if (pair.given && pair.stamp_ns == pair.last_ns)
    return tallied(counters_.time_repeated, Status::time_repeated);
  if (pair.given && pair.stamp_ns < pair.last_ns)
    return tallied(counters_.time_backwards, Status::time_backwards);
  return Status::ok;
}

Status CanSampleDecoder::finish_imu(const CanFrame& gyr, const CanFrame& acc, CanSample& out) {
  out.imu = {};
  out.imu.stamp_ns = imu_.stamp_ns;
  out.imu.flags = rt::kImuGyr | rt::kImuAcc;
  const bool gyr_clipped = decode_axes(gyr, kCanImuGyrFields, out.imu.gyr_rad_s);
  const bool acc_clipped = decode_axes(acc, kCanImuAccFields, out.imu.acc_m_s2);
  if (gyr_clipped || acc_clipped) {
    out.imu.flags |= rt::kImuSaturated | (gyr_clipped ? 0u : +rt::kImuOnlyAccSaturated);
    ++counters_.saturated;
  }
  ++counters_.imu_samples;
  out.kind = CanSampleKind::imu;
  return Status::ok;
}

Status CanSampleDecoder::finish_fix(const CanFrame& across, const CanFrame& up, CanSample& out) {
  const std::int64_t flags = read_can_field(up, kCanFixUpFields[2]);
  if (flags > (rt::kFixPosition | rt::kFixYaw)) {
    counters_.wrong_size += 2;
    return Status::malformed;
  }
  out.fix = {};
  out.fix.stamp_ns = fix_.stamp_ns;
  out.fix.p_world_m[0] = physical_can_field(across, kCanFixAcrossFields[0]);
  out.fix.p_world_m[1] = physical_can_field(across, kCanFixAcrossFields[1]);
  out.fix.p_world_m[2] = physical_can_field(up, kCanFixUpFields[0]);
  out.fix.yaw_rad = physical_can_field(up, kCanFixUpFields[1]);
  out.fix.flags = static_cast<std::uint32_t>(flags);
  ++counters_.fix_samples;
  out.kind = CanSampleKind::fix;
  return Status::ok;
}

Status CanSampleDecoder::finish_track(const CanFrame& left, const CanFrame& right, CanSample& out) {
  // 10,000 s of silence is enough for any travel; the bound keeps the product inside 64 bits.
  constexpr rt::Nanoseconds kLongest = 10'000 * rt::kNanosecondsPerSecond;
  constexpr std::int64_t kSlackCounts = 500;
  rt::Nanoseconds span = track_.given ? track_.stamp_ns - track_.last_ns : 0;
  if (span > kLongest) span = kLongest;
  const std::int64_t limit =
      span / rt::kNanosecondsPerMicrosecond * max_counts_per_s_ / 1'000'000 + kSlackCounts;
  const auto left_raw = static_cast<std::int32_t>(read_can_field(left, kCanTrackLeftFields[0]));
  const auto right_raw = static_cast<std::int32_t>(read_can_field(right, kCanTrackRightFields[0]));
  const bool left_good = left_.update(left_raw, limit);
  const bool right_good = right_.update(right_raw, limit);
  if (!left_good || !right_good) return tallied(counters_.encoder_jumps, Status::out_of_range);
  out.track = {};
  out.track.stamp_ns = track_.stamp_ns;
  out.track.left_m = static_cast<double>(left_.total()) * kCanTrackLeftFields[0].scale;
  out.track.right_m = static_cast<double>(right_.total()) * kCanTrackRightFields[0].scale;
  ++counters_.track_samples;
  out.kind = CanSampleKind::track;
  return Status::ok;
}

}  // namespace sortie::drivers
