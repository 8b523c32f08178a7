// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's commands on the bus, whatever protocol its motors speak.
#include "drivers/can_codec.hpp"
#include "firmware_like/parts/drive_part.hpp"

namespace sortie::firmware {

bool DrivePart::take_frame(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) {
  return emergency_.take(frame, now_ns) || (motors_ && motors_->take(frame, now_ns));
}

void DrivePart::heard(const drivers::CanSample& sample, rt::Nanoseconds now_ns) {
  if (sample.kind == drivers::CanSampleKind::track) own_motors_.note_tracks(now_ns);
}

void DrivePart::poll_devices(const Devices& devices, rt::Nanoseconds now_ns) {
  if (devices.can == nullptr) return;
  rt::DriveCommand command;
  const bool has_command =
      (motors_ || own_motors_.drive_is_due(now_ns)) && drive_outlet_->take(now_ns, command);
  rt::FlipperCommand flippers;
  const bool has_flippers = flipper_outlet_ != nullptr && (motors_ || own_motors_.flippers_are_due(now_ns)) &&
                            flipper_outlet_->take(now_ns, flippers);
  if (has_command) emergency_asked_ = (command.flags & rt::kCommandEmergency) != 0;
  const bool pressed = emergency_.poll(emergency_asked_, now_ns);
  const auto reason = motors_ ? static_cast<std::uint32_t>(motors_->stop_reason()) : 0u;
  motors_news_.store((pressed ? 1u : 0u) | (motors_ && motors_->running() ? 2u : 0u) | reason << 8u,
                     std::memory_order_relaxed);
  const rt::DriveCommand* drive = has_command ? &command : nullptr;
  const rt::FlipperCommand* angles = has_flippers ? &flippers : nullptr;
  if (motors_) {
    motors_->press(pressed);
    send_to_motors(*devices.can, drive, angles, now_ns);
  } else {
    own_motors_.poll(*devices.can, drive, angles, pressed, now_ns);
  }
}

std::optional<MotorsNews> DrivePart::motors_news() const {
  const std::uint32_t word = motors_news_.load(std::memory_order_relaxed);
  return MotorsNews{(word & 1u) != 0, (word & 2u) != 0, word >> 8u};
}

/// These motors say by themselves when something goes out.
void DrivePart::send_to_motors(drivers::CanBus& can, const rt::DriveCommand* command,
                               const rt::FlipperCommand* flippers, rt::Nanoseconds now_ns) {
  const auto note = [](Status status, OwnMotors::Counters& counters) {
    ++(status == Status::ok ? counters.sent : counters.refused);
  };
  if (command != nullptr) note(motors_->set(*command, now_ns), drive_commands_);
  if (flippers != nullptr) note(motors_->set(*flippers, now_ns), flipper_commands_);
  motors_->poll(now_ns, can);
  // A full stream counts its refusals.
  rt::TrackSample tracks;
  if (motors_->read(tracks) == Status::ok && track_port_ != nullptr)
    static_cast<void>(track_port_->push(tracks, now_ns));
  rt::FlipperSample state;
  if (motors_->read(state) == Status::ok && flipper_port_ != nullptr)
    static_cast<void>(flipper_port_->push(state, now_ns));
}

}  // namespace sortie::firmware
