// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/own_motors.hpp"

#include "drivers/can_codec.hpp"

namespace sortie::firmware {

void OwnMotors::note_tracks(rt::Nanoseconds now_ns) noexcept {
  tracks_heard_ = true;
  tracks_ns_ = now_ns;
}

void OwnMotors::poll(drivers::CanBus& can, const rt::DriveCommand* drive, const rt::FlipperCommand* flippers,
                     bool pressed, rt::Nanoseconds now_ns) noexcept {
  const bool lost = tracks_heard_ && now_ns - tracks_ns_ > kTracksLostAfter;
  const bool stops = pressed || lost;
  const auto hear = [&](drivers::RequestLatch& latch, rt::Nanoseconds& heard_ns, std::uint32_t asked) {
    static_cast<void>(latch.hear(asked, now_ns - heard_ns <= kSilence));
    heard_ns = now_ns;
  };
  if (drive != nullptr) hear(drive_latch_, drive_ns_, drive->asked);
  if (flippers != nullptr) hear(flipper_latch_, flippers_ns_, flippers->asked);
  if (stops) {
    drive_latch_.spend();
    flipper_latch_.spend();
  }
  const rt::DriveCommand no_speed;
  if (drive_latch_.spent()) drive = drive_is_due(now_ns) ? &no_speed : nullptr;
  const rt::FlipperCommand no_torque;
  if (flippers_ && flipper_latch_.spent()) flippers = flippers_are_due(now_ns) ? &no_torque : nullptr;
  if (drive != nullptr) send_drive(can, *drive, now_ns);
  if (flippers != nullptr) send_flippers(can, *flippers, now_ns);
}

// A number is used once, whether or not its frame went: where a frame went that was told while the bus was
// off nobody knows, and who hears it late must not take the next command for a repeat.
void OwnMotors::send_drive(drivers::CanBus& can, const rt::DriveCommand& command,
                           rt::Nanoseconds now_ns) noexcept {
  drivers::CanFrame frame;
  if (drivers::encode_drive(command, drive_counter_++, frame) != Status::ok ||
      can.send(frame) != Status::ok) {
    ++drive_counters_.refused;
    return;
  }
  ++drive_counters_.sent;
  next_drive_ns_ = now_ns + kDriveEvery;
}

// Both pairs, or a refusal.
void OwnMotors::send_flippers(drivers::CanBus& can, const rt::FlipperCommand& command,
                              rt::Nanoseconds now_ns) noexcept {
  drivers::CanFrame frames[2];
  if (drivers::encode_flippers(command, flipper_counter_++, frames) != Status::ok ||
      can.send(frames[0]) != Status::ok || can.send(frames[1]) != Status::ok) {
    ++flipper_counters_.refused;
    return;
  }
  ++flipper_counters_.sent;
  next_flippers_ns_ = now_ns + kFlippersEvery;
}

}  // namespace sortie::firmware
