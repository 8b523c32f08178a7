// SPDX-License-Identifier: BSD-3-Clause
// What a run answers to requests, with the state of the task that obeys, under one tag. encode() and decode()
// are those of wire_fields.hpp; for threads that are not real-time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/wire_fields.hpp"
#include "drivers/wire_telemetry.hpp"

namespace sortie::drivers {

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
