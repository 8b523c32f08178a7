// SPDX-License-Identifier: BSD-3-Clause
// Requests to the drive or the pilot of a run, as they come over the network, and what the run answers.
// encode() and decode() are those of wire_fields.hpp; no heap but for answers, which are for threads that are
// not real-time. What the fields of a request may be is for the receiver to judge.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/wire_fields.hpp"
#include "drivers/wire_telemetry.hpp"
#include "rt/describe.hpp"
#include "rt/samples.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::drivers {

/// drive_request_t: a request, and who asks whom and when. Its stamp does not travel.
struct DriveRequestMessage : rt::DriveRequest {
  std::int64_t utime{};    ///< us UTC of the sender's clock
  std::int64_t session{};  ///< of the run that is meant
  std::int64_t sender{};   ///< any number
  SORTIE_FIELDS(utime, session, sender, counter, speed_m_s, turn_rad_s, mode, posture, flags, goal_x_m,
                goal_y_m)
};
template <>
struct WireRules<DriveRequestMessage> : WireTagged {};

/// fly_request_t, made alike.
struct FlyRequestMessage : rt::FlyRequest {
  std::int64_t utime{};    ///< us UTC of the sender's clock
  std::int64_t session{};  ///< of the run that is meant
  std::int64_t sender{};   ///< any number
  static constexpr void fields(auto& self, auto&& visit) {
    SORTIE_VISIT(utime, session, sender, counter)
    visit("x_m", self.p_world_m[0]);
    visit("y_m", self.p_world_m[1]);
    visit("z_m", self.p_world_m[2]);
    SORTIE_VISIT(yaw_rad, mode)
  }
};
template <>
struct WireRules<FlyRequestMessage> : WireTagged {};

/// Bytes of the messages, fingerprint and tag included: always the same.
inline constexpr std::size_t kDriveRequestBytes = kLeastBytes<DriveRequestMessage>;
inline constexpr std::size_t kFlyRequestBytes = kLeastBytes<FlyRequestMessage>;

/// What became of a request.
struct RequestAnswer {
  std::int64_t sender{};
  std::int64_t counter{};
  std::int32_t status{};  ///< Status as a number; ok: admitted
  static constexpr void fields(auto& self, auto&& visit) {
    visit("sender", self.sender);
    visit("asked", self.counter);
    visit("status", self.status);
  }
};

/// request_answers_t. Answer and state stand in one message, and one tag covers both: who reads "admitted"
/// and "halted" in it knows that the robot said so after it had the request.
struct AnswersMessage {
  std::int64_t utime{};
  std::int64_t session{};  ///< of the run; 0: it takes no requests
  std::string robot;       ///< its name, for people
  std::string task;        ///< that obeys
  bool keyed{};            ///< requests need a tag
  std::int64_t counter{};  ///< highest that was taken
  std::vector<RequestAnswer> answers;
  std::vector<NamedValue> state;
  static constexpr void fields(auto& self, auto&& visit) {
    visit("utime", self.utime);
    visit("session", self.session);
    visit("robot", self.robot);
    visit("task", self.task);
    visit("keyed", self.keyed);
    visit("counter", self.counter);
    visit("answers", self.answers);
    visit("n", self.state);
  }
};
template <>
struct WireRules<AnswersMessage> : WireTagged {};

}  // namespace sortie::drivers
