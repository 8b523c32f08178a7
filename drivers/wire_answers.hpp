// SPDX-License-Identifier: BSD-3-Clause
// What a run answers to requests, with the state of the task that obeys, under one tag.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/siphash.hpp"
#include "drivers/wire_telemetry.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// What became of a request.
struct RequestAnswer {
  std::int64_t sender{};
  std::int64_t counter{};
  std::int32_t status{};  ///< Status as a number; ok: admitted
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
};

/// For threads that are not real-time. `key` null: tag 0. Decoding: `bad_checksum` for another type of
/// message, `malformed` for wrong lengths, `disconnected` when `key` is given and the tag is not its;
/// `message` is then unchanged. It allocates, but never more than the message is long.
[[nodiscard]] Status encode(const AnswersMessage& message, const SipKey* key, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> bytes, const SipKey* key, AnswersMessage& message);

}  // namespace sortie::drivers
