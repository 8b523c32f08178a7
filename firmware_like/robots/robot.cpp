// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/robots/robot.hpp"

#include <algorithm>
#include <string_view>

#include "firmware_like/runtime/can_input.hpp"
#include "firmware_like/scene/scene_parts.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

namespace {

struct ListedPart {
  std::string_view name;
  Robot::Maker make;  // null: not in this build; what a scene lacks so was refused before
};

template <rt::PartName name, Robot::Maker make>
constexpr Robot::Maker built_maker() {
  if constexpr (rt::kBuilt<name>) return make;
  return nullptr;
}

constexpr ListedPart kListed[] = {
#define SORTIE_PART(name, ...) {#name, built_maker<#name, make_##name>()},
#define SORTIE_OPTION(name, ...)
    SORTIE_PARTS(SORTIE_PART, SORTIE_OPTION)
#undef SORTIE_PART
#undef SORTIE_OPTION
};

}  // namespace

Robot::Robot(VehicleBuilder& builder, Maker core) {
  if (core != nullptr) parts_.push_back(core(builder));
  make_parts(builder);
  for (const std::unique_ptr<Part>& part : parts_) part->finish(builder);
  imu_kind_ = builder.find<ImuKind>();
  imu_ = builder.find_port<rt::ImuSample>("IMU");
  tracks_ = builder.find_port<rt::TrackSample>("TRACK");
  flippers_ = builder.find_port<rt::FlipperSample>("FLIPPER");
  fixes_ = builder.find_port<rt::UavFix>("FIX");
  builder.check();
}

// Where its parent is not there, a part is not even asked for.
void Robot::make_parts(VehicleBuilder& builder) {
  const std::vector<const ScenePart*> there = parts_of(builder.profile());
  const auto is_there = [&there](std::string_view name) {
    return std::any_of(there.begin(), there.end(),
                       [name](const ScenePart* part) { return name == part->name; });
  };
  for (const ListedPart& listed : kListed) {
    const ScenePart& part = *find_scene_part(std::string(listed.name));
    const std::string_view vehicle = part.vehicle;
    const std::string_view usual = part.usual;
    if (!vehicle.empty() && vehicle != builder.profile().vehicle()) continue;
    if (*part.parent != '\0' && !is_there(part.parent)) continue;
    const bool wanted = builder.wants(part.name, usual == "yes" || (usual != "no" && is_there(usual)));
    if (wanted && listed.make != nullptr) parts_.push_back(listed.make(builder));
  }
}

void Robot::take_frame(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) {
  for (const std::unique_ptr<Part>& part : parts_) {
    if (part->take_frame(frame, now_ns)) return;
  }
  drivers::CanSample sample;
  if (decoder_.decode(frame, sample) != Status::ok) return;  // counted by the decoder, by reason
  push(sample, now_ns);
  for (const std::unique_ptr<Part>& part : parts_) part->heard(sample, now_ns);
}

// A full stream counts its refusals.
void Robot::push(drivers::CanSample& sample, rt::Nanoseconds now_ns) {
  using Kind = drivers::CanSampleKind;
  if (sample.kind == Kind::imu && imu_ != nullptr) {
    if (imu_kind_ != nullptr) sample.imu.flags |= imu_kind_->flags;
    static_cast<void>(imu_->push(sample.imu, now_ns));
  } else if (sample.kind == Kind::track && tracks_ != nullptr) {
    static_cast<void>(tracks_->push(sample.track, now_ns));
  } else if (sample.kind == Kind::flipper && flippers_ != nullptr) {
    static_cast<void>(flippers_->push(sample.flipper, now_ns));
  } else if (sample.kind == Kind::fix && fixes_ != nullptr) {
    static_cast<void>(fixes_->push(sample.fix, now_ns));
  }
}

void Robot::poll_devices(const Devices& devices, rt::Nanoseconds now_ns) {
  if (devices.can != nullptr) {
    if (devices.device_epoch_ns != device_epoch_ns_) {  // at the first call
      drivers::CanCodecConfig codec;
      codec.epoch_ns = device_epoch_ns_ = devices.device_epoch_ns;
      decoder_ = drivers::CanSampleDecoder(codec);
    }
    drivers::CanFrame frame;
    for (int taken = 0; taken < 256 && receive_can(devices, now_ns, frame) == Status::ok; ++taken)
      take_frame(frame, now_ns);
  }
  for (const std::unique_ptr<Part>& part : parts_) part->poll_devices(devices, now_ns);
}

}  // namespace sortie::firmware
