// SPDX-License-Identifier: BSD-3-Clause
// A part of a robot: what it is asked for by the robot that it is in.
#pragma once

#include <memory>

#include "firmware_like/runtime/vehicle.hpp"
#include "firmware_like/scene/part_list.hpp"

namespace sortie::drivers {
struct CanFrame;
struct CanSample;
}  // namespace sortie::drivers

namespace sortie::firmware {

/// A part declares its tasks, streams, parameters and counters in its constructor, where what was made before
/// it can be found (VehicleBuilder::find). To the outside it speaks as a whole vehicle does: what a robot is
/// asked for, its parts are asked for in turn.
///
/// open_devices() and poll_devices() as of Vehicle; frames of the CAN bus come in through take_frame() and
/// heard(), since one bus has many readers.
class Part : public Vehicle {
 public:
  /// When all parts of the robot are made: its frames on the bus, its chains, and whatever depends on parts
  /// that came later. Set-up only; throws ProfileError.
  virtual void finish(VehicleBuilder& /*builder*/) {}
  /// I/O thread: a frame as it came. True when it was meant for this part alone.
  virtual bool take_frame(const drivers::CanFrame& /*frame*/, rt::Nanoseconds /*now_ns*/) { return false; }
  /// I/O thread: a sample of the robot's own frames, which goes into the stream of its kind.
  virtual void heard(const drivers::CanSample& /*sample*/, rt::Nanoseconds /*now_ns*/) {}
};

/// What the frames of the bus do not say of the IMU's samples: rt::ImuFlags that every one of them has.
struct ImuKind {
  std::uint32_t flags{};
};

/// All poses of the robot that became visible since the group's job before, at most 1000, a second of the
/// ground robot's; null without any. The robot's pose is the rt::Task<rt::PoseEstimate> that a part offers.
inline rt::Input<rt::PoseEstimate>* poses_since_last_job(VehicleBuilder& builder, rt::GroupId group) {
  return builder.input(group, builder.find<rt::Task<rt::PoseEstimate>>(), 1000);
}

// Makers of the listed parts, each in the file of its part. Set-up only; throw ProfileError.
#define SORTIE_PART(name, ...) std::unique_ptr<Part> make_##name(VehicleBuilder& builder);
#define SORTIE_OPTION(name, ...)
SORTIE_PARTS(SORTIE_PART, SORTIE_OPTION)
#undef SORTIE_PART
#undef SORTIE_OPTION

}  // namespace sortie::firmware
