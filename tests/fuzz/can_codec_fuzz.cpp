// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: any sequence of frames goes through the CAN decoder. Every frame must be accounted
// for, samples must be finite and in order, and what is decoded must encode to the same bytes.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <limits>

#include "drivers/can_codec.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

/// 13 bytes of input make one frame: stamp step (2), identifier (1), size (1), flags (1), data (8). A high
/// bit in the size byte takes all eight data bytes as the stamp, too.
CanFrame frame_from(const std::uint8_t* in, std::int64_t& now_ns) {
  CanFrame frame;
  now_ns += (in[0] | in[1] << 8) * std::int64_t{10'000};
  frame.stamp_ns = now_ns;
  std::memcpy(frame.data, in + 5, 8);
  if ((in[3] & 0x80) != 0) std::memcpy(&frame.stamp_ns, frame.data, 8);
  frame.id = in[2] < 0x80 ? 0x100u + in[2] : kCanFrames[in[2] % std::size(kCanFrames)].id;
  frame.size = (in[3] & 0x40) != 0
                   ? static_cast<std::uint8_t>(in[3] & 0x3F)
                   : (find_can_frame(frame.id) != nullptr ? find_can_frame(frame.id)->size : in[3]);
  frame.flags = in[4] < 0xC0 ? 0 : in[4];
  return frame;
}

void check_imu(const rt::ImuSample& sample) {
  for (int i = 0; i < 3; ++i)
    require(std::isfinite(sample.gyr_rad_s[i]) && std::isfinite(sample.acc_m_s2[i]));
  CanFrame frames[2];
  require(encode_imu(sample, can_time_counter(sample.stamp_ns), frames) == Status::ok);
  frames[0].stamp_ns = frames[1].stamp_ns = sample.stamp_ns;
  CanSampleDecoder fresh;
  CanSample again;
  require(fresh.decode(frames[0], again) == Status::ok);
  require(fresh.decode(frames[1], again) == Status::ok && again.kind == CanSampleKind::imu);
  require(again.imu.stamp_ns == sample.stamp_ns && again.imu.flags == sample.flags);
  for (int i = 0; i < 3; ++i) {
    // -32768 is encoded as -32767: both mean a clipped axis.
    const bool clipped = (sample.flags & rt::kImuSaturated) != 0;
    require(clipped || again.imu.gyr_rad_s[i] == sample.gyr_rad_s[i]);
    require(clipped || again.imu.acc_m_s2[i] == sample.acc_m_s2[i]);
  }
}

void check_track(const rt::TrackSample& sample) {
  require(std::isfinite(sample.left_m) && std::isfinite(sample.right_m));
  CanFrame frames[2];
  require(encode_track(sample, can_time_counter(sample.stamp_ns), frames) == Status::ok);
}

void check_drive(const CanFrame& frame) {
  rt::DriveCommand command;
  std::uint8_t counter = 0;
  if (decode_drive(frame, command, counter) != Status::ok) return;
  CanFrame again;
  const Status status = encode_drive(command, counter, again);
  if (command.left_m_s < -32.767 || command.right_m_s < -32.767) {  // -32768 mm/s, which no command means
    require(status == Status::out_of_range);
    return;
  }
  require(status == Status::ok && again.size == frame.size);
  require(std::memcmp(again.data, frame.data, again.size) == 0);
}

void check_flippers(const CanFrame& frame) {
  FlipperPairCommand half;
  if (decode_flippers(frame, half) != Status::ok) return;
  const std::uint32_t first = half.pair == FlipperPair::front ? 0 : 2;
  rt::FlipperCommand command;
  command.angle_rad[first] = half.left_rad;
  command.angle_rad[first + 1] = half.right_rad;
  command.flags = half.flags;
  CanFrame again[2];
  const Status status = encode_flippers(command, half.counter, again);
  if (half.left_rad < -6.5535 || half.right_rad < -6.5535) {  // -32768 steps, which no command means
    require(status == Status::out_of_range);
    return;
  }
  require(status == Status::ok && again[first / 2].size == frame.size);
  require(std::memcmp(again[first / 2].data, frame.data, frame.size) == 0);
}

void check_flipper_state(const rt::FlipperSample& sample) {
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i)
    require(std::isfinite(sample.angle_rad[i]) && std::isfinite(sample.torque_n_m[i]));
  CanFrame frames[rt::kFlippers];
  require(encode_flipper_state(sample, can_time_counter(sample.stamp_ns), frames) == Status::ok);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  CanSampleDecoder decoder;
  std::int64_t now_ns = 0;
  std::int64_t last_imu_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t last_track_ns = last_imu_ns;
  std::int64_t last_flipper_ns = last_imu_ns;
  for (std::size_t at = 0; at + 13 <= size; at += 13) {
    const CanFrame frame = frame_from(data + at, now_ns);
    CanSample out;
    const Status status = decoder.decode(frame, out);
    require(status == Status::ok || out.kind == CanSampleKind::none);
    if (out.kind == CanSampleKind::imu) {
      require(out.imu.stamp_ns > last_imu_ns);
      last_imu_ns = out.imu.stamp_ns;
      check_imu(out.imu);
    } else if (out.kind == CanSampleKind::track) {
      require(out.track.stamp_ns > last_track_ns);
      last_track_ns = out.track.stamp_ns;
      check_track(out.track);
    } else if (out.kind == CanSampleKind::flipper) {
      require(out.flipper.stamp_ns > last_flipper_ns);
      last_flipper_ns = out.flipper.stamp_ns;
      check_flipper_state(out.flipper);
    }
    check_flippers(frame);
    check_drive(frame);
  }
  const CanDecodeCounters& c = decoder.counters();
  const std::uint64_t single = c.drive_frames + c.flipper_frames + c.rotor_frames + c.unknown_id +
                               c.remote_frames + c.error_frames + c.wrong_size + c.missing_partner +
                               c.out_of_time;
  const std::uint64_t pairs =
      c.imu_samples + c.track_samples + c.fix_samples + c.time_repeated + c.time_backwards + c.encoder_jumps;
  require(c.frames == single + 2 * pairs + 4 * (c.flipper_samples + c.flipper_order) +
                          static_cast<std::uint64_t>(decoder.pending()));
  return 0;
}
