// SPDX-License-Identifier: BSD-3-Clause
// The robot's own CAN frames by their names in the code. Identifiers, layouts and scales come from
// drivers/dbc/robot.dbc; the codec computes with that table and the documentation prints it, so that none can
// drift from the others.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "drivers/can_bus.hpp"
#include "drivers/can_signal.hpp"
#include "drivers/robot_dbc.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

// Identifiers are 11 bits wide and lie in 0x101..0x180, which CANopen leaves free, so that CANopen drives can
// share the bus. A lower identifier wins the bus.
inline constexpr const auto& kCanFrames = robot::kMessages;

/// Step of the 16-bit time counters. They wrap every 6.5536 s.
inline constexpr rt::Nanoseconds kCanCounterStepNs = 100'000;
/// A raw axis value at or beyond this is a clipped one.
inline constexpr std::int64_t kCanAxisLimit = 32767;

inline constexpr std::uint32_t kCanEmergencyId = robot::kEmergencyStop.id;
inline constexpr std::uint32_t kCanDriveId = robot::kDrive.id;
inline constexpr std::uint32_t kCanFlipperFrontId = robot::kFlipperFront.id;
inline constexpr std::uint32_t kCanFlipperRearId = robot::kFlipperRear.id;
/// First of three, each with three rotors.
inline constexpr std::uint32_t kCanRotorsId = robot::kRotorsA.id;
inline constexpr std::uint32_t kCanRotorFrames = 3;
inline constexpr std::uint32_t kCanImuGyrId = robot::kImuGyr.id;
inline constexpr std::uint32_t kCanImuAccId = robot::kImuAcc.id;
inline constexpr std::uint32_t kCanFixAcrossId = robot::kFixAcross.id;
inline constexpr std::uint32_t kCanFixUpId = robot::kFixUp.id;
inline constexpr std::uint32_t kCanTrackLeftId = robot::kTrackLeft.id;
inline constexpr std::uint32_t kCanTrackRightId = robot::kTrackRight.id;
/// First of four: front left, front right, rear left, rear right (rt::Flipper).
inline constexpr std::uint32_t kCanFlipperStateId = robot::kFlipperFl.id;

inline constexpr const auto& kCanDriveFields = robot::kDriveSignals;
inline constexpr const auto& kCanFlipperFields = robot::kFlipperFrontSignals;
inline constexpr const auto& kCanFlipperStateFields = robot::kFlipperFlSignals;
inline constexpr const auto& kCanRotorFields = robot::kRotorsASignals;
inline constexpr const auto& kCanFixAcrossFields = robot::kFixAcrossSignals;
inline constexpr const auto& kCanFixUpFields = robot::kFixUpSignals;
inline constexpr const auto& kCanImuGyrFields = robot::kImuGyrSignals;
inline constexpr const auto& kCanImuAccFields = robot::kImuAccSignals;
inline constexpr const auto& kCanTrackLeftFields = robot::kTrackLeftSignals;
inline constexpr const auto& kCanTrackRightFields = robot::kTrackRightSignals;

namespace detail {

constexpr bool alike(const CanMessage& a, const CanMessage& b) {
  return a.size == b.size && std::equal(a.fields, a.fields + a.field_count, b.fields,
                                        b.fields + b.field_count, [](const CanSignal& x, const CanSignal& y) {
                                          return std::string_view(x.name) == y.name && x.shift == y.shift &&
                                                 x.length == y.length && x.big_endian == y.big_endian &&
                                                 x.value == y.value && x.scale == y.scale &&
                                                 x.offset == y.offset;
                                        });
}

// Frames that the codec treats as one kind.
static_assert(alike(robot::kFlipperFront, robot::kFlipperRear));
static_assert(alike(robot::kRotorsA, robot::kRotorsB) && alike(robot::kRotorsA, robot::kRotorsC));
static_assert(alike(robot::kFlipperFl, robot::kFlipperFr) && alike(robot::kFlipperFl, robot::kFlipperRl) &&
              alike(robot::kFlipperFl, robot::kFlipperRr));
static_assert(robot::kRotorsC.id == kCanRotorsId + 2 && robot::kFlipperRr.id == kCanFlipperStateId + 3);

}  // namespace detail

/// Metres of track travel per encoder count.
inline constexpr double kCanTrackMetresPerCount = kCanTrackLeftFields[0].scale;

/// The frame of the robot with this identifier, or nullptr. Cost: one pass over the table.
constexpr const CanMessage* find_can_frame(std::uint32_t id) {
  for (const CanMessage& spec : kCanFrames) {
    if (spec.id == id) return &spec;
  }
  return nullptr;
}

}  // namespace sortie::drivers
