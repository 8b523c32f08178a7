// SPDX-License-Identifier: BSD-3-Clause
// The kinds of requests that a run takes. Whoever asks and whoever is asked go by the same lines.
#pragma once

#include <cstdint>
#include <string_view>

#include "drivers/channels.hpp"
#include "drivers/wire_parameters.hpp"
#include "drivers/wire_requests.hpp"
#include "rt/samples.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::firmware {

/// What programs and people call a kind of request.
struct RequestTopic {
  std::string_view channel;
  std::string_view task;  ///< that obeys: its answers and its state are told together; empty: there is none
  std::string_view section;  ///< of the scene: its key `remote` lets requests in
  std::string_view verb;     ///< to drive, to fly
  std::string_view object;   ///< what is driven
  constexpr bool has_task() const { return !task.empty(); }
};

/// A kind of request, by its message. What somebody obeys is a Request: request() makes it, without a stamp.
template <class Message>
struct RequestKind;

template <>
struct RequestKind<drivers::DriveRequestMessage> {
  using Request = rt::DriveRequest;
  static constexpr RequestTopic kTopic{drivers::kChannelDrive, "drive", "drive", "drive", "the robot"};
  static Request request(const drivers::DriveRequestMessage& asked) {
    return {.stamp_ns = 0,
            .counter = asked.counter,
            .speed_m_s = asked.speed_m_s,
            .turn_rad_s = asked.turn_rad_s,
            .mode = static_cast<std::uint32_t>(asked.mode),
            .posture = asked.posture,
            .flags = static_cast<std::uint32_t>(asked.flags)};
  }
};

template <>
struct RequestKind<drivers::FlyRequestMessage> {
  using Request = rt::FlyRequest;
  static constexpr RequestTopic kTopic{drivers::kChannelFly, "pilot", "flight", "fly", "the vehicle"};
  static Request request(const drivers::FlyRequestMessage& asked) {
    return {.stamp_ns = 0,
            .counter = asked.counter,
            .p_world_m = {asked.x_m, asked.y_m, asked.z_m},
            .yaw_rad = asked.yaw_rad,
            .mode = static_cast<std::uint32_t>(asked.mode)};
  }
};

template <>
struct RequestKind<drivers::SetParameter> {
  static constexpr RequestTopic kTopic{drivers::kChannelSet, "", "parameters", "set", "parameters"};
};

}  // namespace sortie::firmware
