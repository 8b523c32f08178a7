// SPDX-License-Identifier: BSD-3-Clause
// The other side of a run's request desk: finds the robot, asks, and hears under the run's tag what became of
// it and what the robot does.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_answers.hpp"
#include "drivers/wire_fly.hpp"
#include "drivers/wire_requests.hpp"

namespace sortie::toolchain {

/// What a client asks for, and by which words a run is told to allow it.
struct RequestTopic {
  std::string task;        ///< that obeys: drive or pilot
  std::string remote_key;  ///< of the scene
  std::string verb;        ///< to drive, to fly
};

/// One thread uses it. With a secret it believes nothing but what carries the tag: neither telemetry nor
/// SORTIE_PARAMETERS tells it where to count on from, or that the robot stands.
class RequestClient {
 public:
  /// Joins the group and opens the way out. Throws std::runtime_error (address, reason, cure).
  RequestClient(const std::string& url, std::optional<drivers::SipKey> key, RequestTopic topic);

  /// Listens until the robot of that name is heard, or (no name) the only one there is; at most so long.
  /// Empty, or what is missing. Throws ProfileError when the right one cannot be told, or the secret is not
  /// its.
  std::string find(const std::string& robot, std::chrono::milliseconds most);
  /// Name of the robot that was found.
  const std::string& robot() const { return heard_.robot; }

  /// Listens for at most so long. True as soon as the robot has said something new.
  bool listen(std::chrono::milliseconds most);
  /// Sends one request, with a counter above all that were taken and sent; session, sender, counter and time
  /// are this one's to fill in. Returns that counter.
  std::int64_t ask(drivers::DriveRequestMessage request);
  std::int64_t ask(drivers::FlyRequestMessage request);
  /// What the robot has answered to the newest of this client's requests from `first` on; nothing yet
  /// otherwise.
  std::optional<Status> answer(std::int64_t first) const;
  /// True when one of them was admitted.
  bool is_admitted(std::int64_t first) const { return answer(first) == Status::ok; }
  /// A value of the task's output, as the newest message has it; 0 when it is not in it.
  double value(const std::string& name) const;
  /// True when the newest message tells the task's state at all.
  bool has_state() const { return !heard_.state.empty(); }
  std::uint64_t sent() const { return sent_; }

 private:
  struct Search;
  void note(std::span<const std::uint8_t> payload, Search& search) const;
  std::string missing(const Search& search) const;
  template <class Message>
  std::int64_t send(std::string_view channel, Message request);

  std::string url_;
  drivers::LcmReceiver receiver_;
  drivers::LcmPublisher publisher_;
  std::optional<drivers::SipKey> key_;
  RequestTopic topic_;
  std::string channel_;
  std::int64_t sender_;
  std::int64_t counter_{};
  std::uint64_t sent_{};
  drivers::AnswersMessage heard_;
};

/// Why the robot refused, for people.
const char* refusal_text(Status status);

}  // namespace sortie::toolchain
