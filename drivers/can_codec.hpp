// SPDX-License-Identifier: BSD-3-Clause
// Frames <-> samples for the robot's own CAN frames (drivers/dbc/robot.dbc). The runtime decodes what the
// sensors send and encodes commands; a device or a simulated plant does the reverse with the same table.
#pragma once

#include <cstdint>

#include "drivers/can_bus.hpp"
#include "drivers/can_flippers.hpp"
#include "drivers/can_frames.hpp"
#include "drivers/can_unwrap.hpp"
#include "rt/describe.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::drivers {

/// How the robot's frames are read.
struct CanCodecConfig {
  rt::Nanoseconds epoch_ns = 0;                ///< when the devices' time counters were 0
  rt::Nanoseconds max_age_ns = 1'000'000'000;  ///< a frame that waited longer for the bus is refused
  rt::Nanoseconds max_ahead_ns = 1'000'000;    ///< a device clock may be this far ahead of the bus stamps
  double max_track_m_s = 20.0;                 ///< a track that seems faster is an encoder that jumped
};

/// What a decoder has seen. Each frame is counted in exactly one of the lines marked (1) or, with its
/// partners, (2) or (4); `saturated` counts samples that are given out and marked.
struct CanDecodeCounters {
  std::uint64_t frames{};           ///< all frames offered
  std::uint64_t imu_samples{};      ///< (2) given out
  std::uint64_t track_samples{};    ///< (2) given out
  std::uint64_t flipper_samples{};  ///< (4) given out
  std::uint64_t drive_frames{};     ///< (1) commands of a runtime on the same bus; not a sample
  std::uint64_t flipper_frames{};   ///< (1) the same for the flippers
  std::uint64_t rotor_frames{};     ///< (1) the same for the rotors of a UAV
  std::uint64_t fix_samples{};      ///< (2) given out
  std::uint64_t unknown_id{};       ///< (1) not a frame of this robot
  std::uint64_t remote_frames{};    ///< (1) remote requests
  std::uint64_t error_frames{};     ///< (1) error frames of the controller
  std::uint64_t wrong_size{};       ///< (1) right identifier, wrong number of bytes or undefined flags
  std::uint64_t missing_partner{};  ///< (1) a half whose other half did not come
  std::uint64_t out_of_time{};      ///< (1) time counter does not fit the bus stamp
  std::uint64_t time_repeated{};    ///< (2) complete, but with the stamp of the sample before
  std::uint64_t time_backwards{};   ///< (2) complete, but older than the sample before
  std::uint64_t encoder_jumps{};    ///< (2) complete, but the travel is not believable
  std::uint64_t flipper_order{};    ///< (4) complete, but not newer than the sample before
  std::uint64_t saturated{};        ///< IMU samples with a clipped axis
  SORTIE_FIELDS(frames, imu_samples, track_samples, flipper_samples, drive_frames, flipper_frames,
                rotor_frames, fix_samples, unknown_id, remote_frames, error_frames, wrong_size,
                missing_partner, out_of_time, time_repeated, time_backwards, encoder_jumps, flipper_order,
                saturated)
};

/// What a frame completed.
enum class CanSampleKind : std::uint8_t { none, imu, track, flipper, fix };

/// A decoded sample; only the member named by `kind` is valid.
struct CanSample {
  CanSampleKind kind{};
  rt::ImuSample imu{};
  rt::TrackSample track{};
  rt::FlipperSample flipper{};
  rt::UavFix fix{};
};

/// Turns the sensors' frames into samples. Trusts nothing: what does not fit is dropped and counted by
/// reason. Fixed memory, about 500 bytes; no heap, no exception; about 50 ns a frame. One thread.
class CanSampleDecoder {
 public:
  explicit CanSampleDecoder(const CanCodecConfig& config = {});

  /// Takes one frame in bus order. `out.kind` says what it completed; a first half completes nothing.
  /// Status: ok; otherwise nothing is given out and a counter says why: malformed (size, flags),
  /// not_supported (not a frame of this robot, remote, error), stale (time counter against bus stamp),
  /// time_repeated, time_backwards, out_of_range (encoder jump, absurd stamp).
  [[nodiscard]] Status decode(const CanFrame& frame, CanSample& out) noexcept;

  /// What was seen since construction.
  const CanDecodeCounters& counters() const noexcept { return counters_; }

  /// Frames that wait for their partners now: 0 to 6.
  int pending() const noexcept {
    return (imu_.waiting ? 1 : 0) + (track_.waiting ? 1 : 0) + (fix_.waiting ? 1 : 0) + flippers_.waiting();
  }

 private:
  struct Pair {
    bool waiting{};  // one half is here
    bool second{};   // ... and it is the second one
    bool given{};    // last_ns is valid
    rt::Nanoseconds stamp_ns{};
    rt::Nanoseconds last_ns{};
    CanFrame half{};
  };
  Status join(Pair& pair, const CanFrame& frame, bool second, const CanSignal& time, bool& complete);
  Status check_order(Pair& pair);
  Status join_flipper(const CanFrame& frame, CanSample& out);
  Status finish_imu(const CanFrame& gyr, const CanFrame& acc, CanSample& out);
  Status finish_track(const CanFrame& left, const CanFrame& right, CanSample& out);
  Status finish_fix(const CanFrame& across, const CanFrame& up, CanSample& out);

  CanCounterClock clock_;
  std::int64_t max_counts_per_s_;
  Pair imu_{};
  Pair track_{};
  Pair fix_{};
  FlipperJoin flippers_{};
  EncoderUnwrap left_{};
  EncoderUnwrap right_{};
  CanDecodeCounters counters_{};
};

/// The time counter a device puts into its frames for a sample of `stamp_ns`.
std::uint16_t can_time_counter(rt::Nanoseconds stamp_ns, const CanCodecConfig& config = {});

/// Encodes an IMU sample as two frames: out[0] gyro, out[1] accelerometer. Axes beyond the range are clipped
/// to +-32767, as a device clips them. The frames carry the sample's stamp until a bus stamps them. Status:
/// ok, not_finite (nothing written).
[[nodiscard]] Status encode_imu(const rt::ImuSample& sample, std::uint16_t counter, CanFrame out[2]) noexcept;

/// Encodes track travel as two frames: out[0] left, out[1] right. The count wraps at 32 bits. Status: ok,
/// not_finite, out_of_range (beyond 2^53 counts); nothing is written then.
[[nodiscard]] Status encode_track(const rt::TrackSample& sample, std::uint16_t counter,
                                  CanFrame out[2]) noexcept;

/// Encodes a fix as two frames: out[0] across, out[1] up. Status: ok, not_finite, out_of_range (beyond 8.3
/// km, or more than half a turn from 0) of what the fix carries; nothing is written then. What it does not
/// carry is not looked at: the frames say zero, and its bit that it is none.
[[nodiscard]] Status encode_fix(const rt::UavFix& fix, std::uint16_t counter, CanFrame out[2]) noexcept;

/// Encodes speeds for the rotors as three frames; without flag 1 they are for standing rotors. Status: ok,
/// not_finite, out_of_range (below 0, beyond 1310 rad/s, or more than 8 rotors); nothing is written then.
[[nodiscard]] Status encode_rotors(const rt::RotorCommand& command, std::uint8_t counter,
                                   CanFrame out[kCanRotorFrames]) noexcept;

/// One third of a command to the rotors.
struct CanRotorThird {
  std::uint32_t first{};  ///< number of its first rotor
  double speed_rad_s[3]{};
  std::uint8_t counter{};
  bool enabled{};
};
/// Status: ok, not_supported (not a frame for the rotors), malformed (size or undefined flag bits).
[[nodiscard]] Status decode_rotors(const CanFrame& frame, CanRotorThird& third) noexcept;

/// Encodes a drive command. Status: ok, not_finite, out_of_range (beyond +-32.767 m/s); nothing is written
/// then: a command is never bent silently.
[[nodiscard]] Status encode_drive(const rt::DriveCommand& command, std::uint8_t counter,
                                  CanFrame& out) noexcept;

/// Decodes a drive command; its stamp is the frame's bus stamp, its waypoint 0. Status: ok, not_supported
/// (not a drive frame), malformed (size or undefined flag bits); nothing is written then.
[[nodiscard]] Status decode_drive(const CanFrame& frame, rt::DriveCommand& command,
                                  std::uint8_t& counter) noexcept;

}  // namespace sortie::drivers
