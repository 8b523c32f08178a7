// SPDX-License-Identifier: BSD-3-Clause
// Samples as frames on a bus, and the book-keeping of the decoder that hears them.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>

#include "drivers/can_codec.hpp"

namespace sortie::drivers::rig {

inline rt::ImuSample imu_at(std::int64_t stamp_ns) {
  rt::ImuSample s;
  s.stamp_ns = stamp_ns;
  s.gyr_rad_s[0] = 0.1;
  s.gyr_rad_s[1] = -0.2;
  s.gyr_rad_s[2] = 1.5;
  s.acc_m_s2[0] = -1.0;
  s.acc_m_s2[1] = 0.5;
  s.acc_m_s2[2] = 9.81;
  s.flags = rt::kImuGyr | rt::kImuAcc;
  return s;
}

/// Frames of a sample as they come from a bus that adds a delay.
inline void imu_frames(const rt::ImuSample& sample, CanFrame out[2], std::int64_t delay_ns = 300'000) {
  REQUIRE(encode_imu(sample, can_time_counter(sample.stamp_ns), out) == Status::ok);
  out[0].stamp_ns = sample.stamp_ns + delay_ns;
  out[1].stamp_ns = sample.stamp_ns + delay_ns + 250'000;
}

inline void track_frames(std::int64_t stamp_ns, double left_m, double right_m, CanFrame out[2]) {
  rt::TrackSample sample;
  sample.stamp_ns = stamp_ns;
  sample.left_m = left_m;
  sample.right_m = right_m;
  REQUIRE(encode_track(sample, can_time_counter(stamp_ns), out) == Status::ok);
  out[0].stamp_ns = stamp_ns + 200'000;
  out[1].stamp_ns = stamp_ns + 400'000;
}

inline void check_balance(const CanSampleDecoder& decoder) {
  const CanDecodeCounters& c = decoder.counters();
  const std::uint64_t single = c.drive_frames + c.flipper_frames + c.rotor_frames + c.unknown_id +
                               c.remote_frames + c.error_frames + c.wrong_size + c.missing_partner +
                               c.out_of_time;
  const std::uint64_t pairs =
      c.imu_samples + c.track_samples + c.fix_samples + c.time_repeated + c.time_backwards + c.encoder_jumps;
  CHECK(c.frames == single + 2 * pairs + 4 * (c.flipper_samples + c.flipper_order) +
                        static_cast<std::uint64_t>(decoder.pending()));
}

}  // namespace sortie::drivers::rig
