// SPDX-License-Identifier: BSD-3-Clause
// The kinds of requests that a run takes. Whoever asks and whoever is asked go by the same lines.
#pragma once

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

/// A kind of request, by its message. What somebody obeys is a Request: the message is one.
template <class Message>
struct RequestKind;

template <>
struct RequestKind<drivers::DriveRequestMessage> {
  using Request = rt::DriveRequest;
  static constexpr RequestTopic kTopic{drivers::kChannelDrive, "drive", "drive", "drive", "the robot"};
};

template <>
struct RequestKind<drivers::FlyRequestMessage> {
  using Request = rt::FlyRequest;
  static constexpr RequestTopic kTopic{drivers::kChannelFly, "pilot", "flight", "fly", "the vehicle"};
};

template <>
struct RequestKind<drivers::SetParameter> {
  static constexpr RequestTopic kTopic{drivers::kChannelSet, "", "parameters", "set", "parameters"};
};

}  // namespace sortie::firmware
