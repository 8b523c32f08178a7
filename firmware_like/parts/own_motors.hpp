// SPDX-License-Identifier: BSD-3-Clause
// Motors on the robot's own frames (drivers/dbc/robot.dbc): when commands go out, and what stops them.
#pragma once

#include <cstdint>

#include "drivers/can_bus.hpp"
#include "drivers/request_latch.hpp"
#include "rt/samples.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// The runtime's side of them. Their supervision is their own: they stop when commands end. What is kept here
/// is what DriveGroup keeps for drives on other protocols (docs/safety.md): after an emergency stop, and
/// after the tracks have been silent, nothing moves until it is asked for anew. While something is stopped
/// its frames go on at their pace, with speed 0 and "not enabled", whether or not anybody still has commands.
///
/// One thread; no heap, no clock of its own, under a microsecond a poll.
class OwnMotors {
 public:
  static constexpr rt::Nanoseconds kDriveEvery = 10 * rt::kNanosecondsPerMillisecond;  // 2 % of 500 kbit/s
  static constexpr rt::Nanoseconds kFlippersEvery = 20 * rt::kNanosecondsPerMillisecond;
  /// A request that comes with the end of a silence may have been made before a stop: it does not count.
  static constexpr rt::Nanoseconds kSilence = 200 * rt::kNanosecondsPerMillisecond;
  static constexpr rt::Nanoseconds kTracksLostAfter = 150 * rt::kNanosecondsPerMillisecond;

  /// Counts since construction.
  struct Counters {
    std::uint64_t sent{};
    std::uint64_t refused{};
  };

  explicit OwnMotors(bool flippers = false) : flippers_(flippers) {}

  /// The bus has room for a command. Until then the newest waits where it is.
  bool drive_is_due(rt::Nanoseconds now_ns) const noexcept { return now_ns >= next_drive_ns_; }
  bool flippers_are_due(rt::Nanoseconds now_ns) const noexcept { return now_ns >= next_flippers_ns_; }
  /// The tracks were read.
  void note_tracks(rt::Nanoseconds now_ns) noexcept;

  /// Once a poll, with the commands that are due, or null. `pressed`: an emergency stop.
  void poll(drivers::CanBus& can, const rt::DriveCommand* drive, const rt::FlipperCommand* flippers,
            bool pressed, rt::Nanoseconds now_ns) noexcept;

  const Counters& drive_counters() const noexcept { return drive_counters_; }
  const Counters& flipper_counters() const noexcept { return flipper_counters_; }

 private:
  void send_drive(drivers::CanBus& can, const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept;
  void send_flippers(drivers::CanBus& can, const rt::FlipperCommand& command,
                     rt::Nanoseconds now_ns) noexcept;

  bool flippers_;
  bool tracks_heard_{};
  std::uint8_t drive_counter_{};
  std::uint8_t flipper_counter_{};
  drivers::RequestLatch drive_latch_{false};  // until the first stop they do what they are told
  drivers::RequestLatch flipper_latch_{false};
  rt::Nanoseconds tracks_ns_{};
  // When a command came. Never yet: what the first one brings was asked before any stop that it finds.
  rt::Nanoseconds drive_ns_{-1 - kSilence};
  rt::Nanoseconds flippers_ns_{-1 - kSilence};
  rt::Nanoseconds next_drive_ns_{};
  rt::Nanoseconds next_flippers_ns_{};
  Counters drive_counters_{};
  Counters flipper_counters_{};
};

}  // namespace sortie::firmware
