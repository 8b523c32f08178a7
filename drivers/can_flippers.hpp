// SPDX-License-Identifier: BSD-3-Clause
// The flippers on the bus: position commands for the two pairs, and four frames of state that make one
// sample.
#pragma once

#include <bit>
#include <cstdint>

#include "drivers/can_frames.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// The two flippers that one command frame speaks to.
enum class FlipperPair : std::uint8_t { front, rear };

/// A decoded half of a flipper command.
struct FlipperPairCommand {
  rt::Nanoseconds stamp_ns{};  ///< bus stamp
  FlipperPair pair{};
  double left_rad{};
  double right_rad{};
  std::uint32_t flags{};  ///< bit 0: enabled
  std::uint8_t counter{};
};

/// Encodes a command as two frames, out[0] front and out[1] rear, each with the same counter. Either is a
/// whole command for its pair; the other one's loss does no harm. Status: ok, not_finite, out_of_range
/// (beyond +-6.5534 rad); nothing is written then.
[[nodiscard]] Status encode_flippers(const rt::FlipperCommand& command, std::uint8_t counter,
                                     CanFrame out[2]) noexcept;

/// Decodes one frame of a command. Status: ok, not_supported (not such a frame), malformed (size, undefined
/// flag bits); nothing is written then. Whether the counter repeats is for the device to judge.
[[nodiscard]] Status decode_flippers(const CanFrame& frame, FlipperPairCommand& command) noexcept;

/// Encodes the state of all flippers as a device does, in the order of rt::Flipper. Angles and torques beyond
/// the field are clipped to +-32767 steps. Status: ok, not_finite (nothing written).
[[nodiscard]] Status encode_flipper_state(const rt::FlipperSample& sample, std::uint16_t counter,
                                          CanFrame out[rt::kFlippers]) noexcept;

/// Puts four frames with the same time together, in any order. A frame of another time, or the same
/// flipper's again, drops what waited in its way. 48 bytes.
class FlipperJoin {
 public:
  /// Takes one frame's content; `flipper` below 4. Returns how many frames that waited were dropped;
  /// `complete`: take() has a sample now.
  std::uint64_t add(std::uint32_t flipper, rt::Nanoseconds stamp_ns, std::int16_t angle, std::int16_t torque,
                    bool& complete) noexcept;
  /// Gives the whole sample out and forgets it. Status: ok, time_repeated, time_backwards (against the
  /// sample given out before; nothing is written then).
  [[nodiscard]] Status take(rt::FlipperSample& out) noexcept;
  /// Frames that wait.
  int waiting() const noexcept { return std::popcount(present_); }

 private:
  std::uint8_t present_{};
  bool given_{};
  rt::Nanoseconds stamp_ns_{};
  rt::Nanoseconds last_ns_{};
  std::int16_t angle_[rt::kFlippers]{};
  std::int16_t torque_[rt::kFlippers]{};
};

}  // namespace sortie::drivers
