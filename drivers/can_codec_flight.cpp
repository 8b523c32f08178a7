// SPDX-License-Identifier: BSD-3-Clause
// Frames of a UAV: fixes of its place to frames, commands to its rotors there and back. No state.
#include <algorithm>
#include <cmath>

#include "drivers/can_codec.hpp"
#include "drivers/can_raw.hpp"

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kRotorsEnabled = 1u;
constexpr std::uint32_t kPerFrame = 3;
constexpr double kFarthest_m = 8388.0;  // three bytes of millimetres
constexpr double kMostSpeed_rad_s = 65535.0 * kCanRotorFields[0].scale;

}  // namespace

Status encode_fix(const rt::UavFix& fix, std::uint16_t counter, CanFrame out[2]) noexcept {
  // What the fix does not carry is not looked at; the frames say zero.
  double place_m[3]{};
  double yaw_rad = 0.0;
  if ((fix.flags & rt::kFixPosition) != 0) std::copy_n(fix.p_world_m, 3, place_m);
  if ((fix.flags & rt::kFixYaw) != 0) yaw_rad = fix.yaw_rad;
  for (const double place : place_m) {
    if (!std::isfinite(place)) return Status::not_finite;
    if (std::fabs(place) > kFarthest_m) return Status::out_of_range;
  }
  if (!std::isfinite(yaw_rad)) return Status::not_finite;
  if (std::fabs(yaw_rad) > 3.2) return Status::out_of_range;
  out[0] = blank(kCanFixAcrossId, fix.stamp_ns);
  out[1] = blank(kCanFixUpId, fix.stamp_ns);
  for (std::size_t i = 0; i < 2; ++i)
    write_can_field(out[0], kCanFixAcrossFields[i], to_raw(place_m[i], kCanFixAcrossFields[i].scale));
  write_can_field(out[0], kCanFixAcrossFields[2], counter);
  write_can_field(out[1], kCanFixUpFields[0], to_raw(place_m[2], kCanFixUpFields[0].scale));
  write_can_field(out[1], kCanFixUpFields[1], to_raw(yaw_rad, kCanFixUpFields[1].scale));
  write_can_field(out[1], kCanFixUpFields[2], fix.flags & (rt::kFixPosition | rt::kFixYaw));
  write_can_field(out[1], kCanFixUpFields[3], counter);
  return Status::ok;
}

Status encode_rotors(const rt::RotorCommand& command, std::uint8_t counter,
                     CanFrame out[kCanRotorFrames]) noexcept {
  if (command.rotors > rt::kMaxRotors) return Status::out_of_range;
  for (std::uint32_t i = 0; i < command.rotors; ++i) {
    if (!std::isfinite(command.speed_rad_s[i])) return Status::not_finite;
    if (command.speed_rad_s[i] < 0.0 || command.speed_rad_s[i] > kMostSpeed_rad_s)
      return Status::out_of_range;
  }
  for (std::uint32_t f = 0; f < kCanRotorFrames; ++f) {
    out[f] = blank(kCanRotorsId + f, command.stamp_ns);
    for (std::uint32_t i = 0; i < kPerFrame; ++i) {
      const std::uint32_t rotor = kPerFrame * f + i;
      const double speed = rotor < command.rotors ? command.speed_rad_s[rotor] : 0.0;
      write_can_field(out[f], kCanRotorFields[i], to_raw(speed, kCanRotorFields[i].scale));
    }
    write_can_field(out[f], kCanRotorFields[3], counter);
    write_can_field(out[f], kCanRotorFields[4], command.flags & kRotorsEnabled);
  }
  return Status::ok;
}

Status decode_rotors(const CanFrame& frame, CanRotorThird& third) noexcept {
  if (frame.id < kCanRotorsId || frame.id >= kCanRotorsId + kCanRotorFrames || frame.flags != 0)
    return Status::not_supported;
  if (frame.size != find_can_frame(kCanRotorsId)->size) return Status::malformed;
  const std::int64_t flags = read_can_field(frame, kCanRotorFields[4]);
  if (flags > kRotorsEnabled) return Status::malformed;
  third.first = kPerFrame * (frame.id - kCanRotorsId);
  for (std::size_t i = 0; i < kPerFrame; ++i)
    third.speed_rad_s[i] = physical_can_field(frame, kCanRotorFields[i]);
  third.counter = static_cast<std::uint8_t>(read_can_field(frame, kCanRotorFields[3]));
  third.enabled = flags != 0;
  return Status::ok;
}

}  // namespace sortie::drivers
