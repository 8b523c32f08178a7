// SPDX-License-Identifier: BSD-3-Clause
// Requests as bytes, and a desk to put them on.
#pragma once

#include <catch2/catch.hpp>
#include <vector>

#include "firmware_like/link/request_desk.hpp"

namespace sortie::testing {

using DriveRequestDesk = firmware::RequestDesk<drivers::DriveRequestMessage>;
using FlyRequestDesk = firmware::RequestDesk<drivers::FlyRequestMessage>;

template <class Message>
std::vector<std::uint8_t> bytes_of(const Message& request, const drivers::SipKey* key) {
  std::vector<std::uint8_t> bytes(256);
  std::size_t size = 0;
  REQUIRE(drivers::encode(request, key, bytes, size) == Status::ok);
  bytes.resize(size);
  return bytes;
}

/// Taken at once, in session 0, at `now_ns` of the run's clock; the sender's clock is not judged.
inline firmware::RequestContext at(rt::Nanoseconds now_ns, const drivers::SipKey* key = nullptr) {
  return {key, 0, now_ns, {}};
}

/// The newest answer to a sender, or nothing.
template <class Desk>
std::optional<drivers::RequestAnswer> answer_to(const Desk& desk, std::int64_t sender) {
  drivers::AnswersMessage message;
  desk.describe(message);
  std::optional<drivers::RequestAnswer> newest;
  for (const drivers::RequestAnswer& answer : message.answers) {
    if (answer.sender == sender && (!newest || answer.counter > newest->counter)) newest = answer;
  }
  return newest;
}

}  // namespace sortie::testing
