// SPDX-License-Identifier: BSD-3-Clause
// The robot's own CAN frames: identifiers, layouts and scales in one table. The codec computes with this
// table and the documentation prints it, so that neither can drift from the other.
#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/can_bus.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// One field of a frame: little endian, whole bytes, physical value = raw * scale.
struct CanFieldSpec {
  const char* name;
  std::uint8_t first_byte;
  std::uint8_t bytes;
  bool is_signed;
  double scale;
  const char* unit;
  const char* meaning;
};

/// One frame of the robot. Identifiers are 11 bits wide and lie in 0x101..0x180, which CANopen leaves free,
/// so that CANopen drives can share the bus. A lower identifier wins the bus.
struct CanFrameSpec {
  const char* name;
  std::uint32_t id;
  std::uint8_t size;
  const CanFieldSpec* fields;
  std::size_t field_count;
  const char* meaning;
};

/// Step of the 16-bit time counters. They wrap every 6.5536 s.
inline constexpr rt::Nanoseconds kCanCounterStepNs = 100'000;
/// A raw axis value at or beyond this is a clipped one.
inline constexpr std::int64_t kCanAxisLimit = 32767;

inline constexpr std::uint32_t kCanDriveId = 0x110;
inline constexpr std::uint32_t kCanFlipperFrontId = 0x111;
inline constexpr std::uint32_t kCanFlipperRearId = 0x112;
/// First of three, each with three rotors.
inline constexpr std::uint32_t kCanRotorsId = 0x114;
inline constexpr std::uint32_t kCanRotorFrames = 3;
inline constexpr std::uint32_t kCanImuGyrId = 0x120;
inline constexpr std::uint32_t kCanImuAccId = 0x121;
inline constexpr std::uint32_t kCanFixAcrossId = 0x128;
inline constexpr std::uint32_t kCanFixUpId = 0x129;
inline constexpr std::uint32_t kCanTrackLeftId = 0x130;
inline constexpr std::uint32_t kCanTrackRightId = 0x131;
/// First of four: front left, front right, rear left, rear right (rt::Flipper).
inline constexpr std::uint32_t kCanFlipperStateId = 0x140;

inline constexpr CanFieldSpec kCanDriveFields[] = {
    {"left", 0, 2, true, 0.001, "m/s", "asked speed of the left track"},
    {"right", 2, 2, true, 0.001, "m/s", "asked speed of the right track"},
    {"counter", 4, 1, false, 1.0, "-", "one more with every command; a repeat is a stuck sender"},
    {"flags", 5, 1, false, 1.0, "-", "bit 0: enabled; the other bits are 0"},
};
inline constexpr CanFieldSpec kCanFlipperFields[] = {
    {"left", 0, 2, true, 0.0002, "rad", "asked angle of the left flipper to the body, tip up"},
    {"right", 2, 2, true, 0.0002, "rad", "asked angle of the right flipper to the body, tip up"},
    {"counter", 4, 1, false, 1.0, "-", "one more with every command; a repeat is a stuck sender"},
    {"flags", 5, 1, false, 1.0, "-", "bit 0: enabled; the other bits are 0"},
};
inline constexpr CanFieldSpec kCanFlipperStateFields[] = {
    {"angle", 0, 2, true, 0.0002, "rad", "angle to the body, tip up"},
    {"torque", 2, 2, true, 0.01, "N m", "torque of the drive, turning the tip up"},
    {"time", 4, 2, false, 0.0001, "s", "when it was measured, the same in all four frames"},
};
inline constexpr CanFieldSpec kCanRotorFields[] = {
    {"a", 0, 2, false, 0.02, "rad/s",
     "asked speed of the first of three rotors; 0: there is none, or it stands"},
    {"b", 2, 2, false, 0.02, "rad/s", "asked speed of the second"},
    {"c", 4, 2, false, 0.02, "rad/s", "asked speed of the third"},
    {"counter", 6, 1, false, 1.0, "-", "one more with every command; a repeat is a stuck sender"},
    {"flags", 7, 1, false, 1.0, "-", "bit 0: enabled; the other bits are 0"},
};
inline constexpr CanFieldSpec kCanFixAcrossFields[] = {
    {"x", 0, 3, true, 0.001, "m", "place in the world"},
    {"y", 3, 3, true, 0.001, "m", "place in the world"},
    {"time", 6, 2, false, 0.0001, "s", "when it was true, modulo 6.5536 s"},
};
inline constexpr CanFieldSpec kCanFixUpFields[] = {
    {"z", 0, 3, true, 0.001, "m", "height in the world"},
    {"yaw", 3, 2, true, 0.0001, "rad", "heading"},
    {"flags", 5, 1, false, 1.0, "-",
     "bit 0: the place is valid; bit 1: the heading is; the other bits are 0"},
    {"time", 6, 2, false, 0.0001, "s", "the same value as in the other frame of the fix"},
};
inline constexpr CanFieldSpec kCanImuGyrFields[] = {
    {"x", 0, 2, true, 0.0005, "rad/s", "turn rate about body x (forward)"},
    {"y", 2, 2, true, 0.0005, "rad/s", "turn rate about body y (left)"},
    {"z", 4, 2, true, 0.0005, "rad/s", "turn rate about body z (up)"},
    {"time", 6, 2, false, 0.0001, "s", "when it was measured, modulo 6.5536 s"},
};
inline constexpr CanFieldSpec kCanImuAccFields[] = {
    {"x", 0, 2, true, 0.005, "m/s^2", "specific force along body x"},
    {"y", 2, 2, true, 0.005, "m/s^2", "specific force along body y"},
    {"z", 4, 2, true, 0.005, "m/s^2", "specific force along body z (+9.81 at rest)"},
    {"time", 6, 2, false, 0.0001, "s", "the same value as in the gyro frame that belongs to it"},
};
inline constexpr CanFieldSpec kCanTrackLeftFields[] = {
    {"travel", 0, 4, true, 0.0001, "m", "travel of the left track since start, wraps"},
    {"time", 4, 2, false, 0.0001, "s", "when it was measured, modulo 6.5536 s"},
};
inline constexpr CanFieldSpec kCanTrackRightFields[] = {
    {"travel", 0, 4, true, 0.0001, "m", "travel of the right track since start, wraps"},
    {"time", 4, 2, false, 0.0001, "s", "the same value as in the left frame that belongs to it"},
};

/// All frames of the robot, by identifier.
inline constexpr CanFrameSpec kCanFrames[] = {
    {"drive", kCanDriveId, 6, kCanDriveFields, 4, "speed command to the drives"},
    {"flipper_front", kCanFlipperFrontId, 6, kCanFlipperFields, 4, "position command to the front flippers"},
    {"flipper_rear", kCanFlipperRearId, 6, kCanFlipperFields, 4, "position command to the rear flippers"},
    {"rotors_a", kCanRotorsId, 8, kCanRotorFields, 5, "speed command to rotors 1 to 3"},
    {"rotors_b", kCanRotorsId + 1, 8, kCanRotorFields, 5, "speed command to rotors 4 to 6"},
    {"rotors_c", kCanRotorsId + 2, 8, kCanRotorFields, 5, "speed command to rotors 7 and 8"},
    {"imu_gyr", kCanImuGyrId, 8, kCanImuGyrFields, 4, "gyro half of an IMU sample"},
    {"imu_acc", kCanImuAccId, 8, kCanImuAccFields, 4, "accelerometer half of an IMU sample"},
    {"fix_across", kCanFixAcrossId, 8, kCanFixAcrossFields, 3, "horizontal half of a fix of a UAV's place"},
    {"fix_up", kCanFixUpId, 8, kCanFixUpFields, 4, "the other half: height and heading"},
    {"track_left", kCanTrackLeftId, 6, kCanTrackLeftFields, 2, "left half of an encoder sample"},
    {"track_right", kCanTrackRightId, 6, kCanTrackRightFields, 2, "right half of an encoder sample"},
    {"flipper_fl", kCanFlipperStateId, 6, kCanFlipperStateFields, 3, "state of the front left flipper"},
    {"flipper_fr", kCanFlipperStateId + 1, 6, kCanFlipperStateFields, 3, "state of the front right flipper"},
    {"flipper_rl", kCanFlipperStateId + 2, 6, kCanFlipperStateFields, 3, "state of the rear left flipper"},
    {"flipper_rr", kCanFlipperStateId + 3, 6, kCanFlipperStateFields, 3, "state of the rear right flipper"},
};

/// Metres of track travel per encoder count.
inline constexpr double kCanTrackMetresPerCount = kCanTrackLeftFields[0].scale;

/// The frame of the robot with this identifier, or nullptr. Cost: one pass over the table.
constexpr const CanFrameSpec* find_can_frame(std::uint32_t id) {
  for (const CanFrameSpec& spec : kCanFrames) {
    if (spec.id == id) return &spec;
  }
  return nullptr;
}

/// Reads the raw value of a field. The field must lie inside the frame's data. Cost: a few instructions.
constexpr std::int64_t read_can_field(const CanFrame& frame, const CanFieldSpec& field) {
  std::uint64_t raw = 0;
  for (unsigned i = 0; i < field.bytes; ++i) {
    raw |= static_cast<std::uint64_t>(frame.data[field.first_byte + i]) << (8u * i);
  }
  if (field.is_signed && field.bytes > 0) {
    const std::uint64_t sign = std::uint64_t{1} << (8u * field.bytes - 1u);
    if ((raw & sign) != 0) raw |= ~(sign * 2u - 1u);
  }
  return static_cast<std::int64_t>(raw);
}

/// Writes the low bytes of `raw` into a field (a wrapping counter wraps here).
constexpr void write_can_field(CanFrame& frame, const CanFieldSpec& field, std::int64_t raw) {
  const auto bits = static_cast<std::uint64_t>(raw);
  // The second bound always holds; GCC 12 at -O3 warns where it cannot see that.
  for (unsigned i = 0; i < field.bytes && field.first_byte + i < sizeof(frame.data); ++i) {
    frame.data[field.first_byte + i] = static_cast<std::uint8_t>(bits >> (8u * i) & 0xFFu);
  }
}

}  // namespace sortie::drivers
