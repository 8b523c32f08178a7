// SPDX-License-Identifier: BSD-3-Clause
// The other side of a run's request door: finds the run, asks, and hears what became of it and what the run
// does.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_requests.hpp"
#include "firmware_like/link/request_kind.hpp"

namespace sortie::toolchain {

/// How a client sends to a run on this address: requests are small and few.
drivers::LcmPublisherConfig request_publisher(const std::string& url);
/// Microseconds UTC.
std::int64_t utc_us();

/// One thread uses it. Of a task, and with a secret, it believes nothing but what carries the tag: neither
/// telemetry nor SORTIE_PARAMETERS tells it where to count on from, or that the robot stands. Of parameters
/// that message is all there is, and it carries none.
class RequestClient {
 public:
  /// Joins the group and opens the way out. Throws std::runtime_error (address, reason, cure).
  RequestClient(const std::string& url, std::optional<drivers::SipKey> key,
                const firmware::RequestTopic& topic);

  /// Listens until the robot of that name (of parameters: the run of that session) is heard, or (no name) the
  /// only one there is; at most so long. Empty, or what is missing. Throws ProfileError when the right one
  /// cannot be told, or the secret is not its.
  std::string find(const std::string& whom, std::chrono::milliseconds most);
  const firmware::RequestTopic& topic() const { return topic_; }
  /// Name of the robot that was found; of parameters its session, as digits.
  const std::string& robot() const { return heard_.robot; }
  /// What the run said of its parameters; of a task nothing.
  const drivers::ParametersMessage& parameters() const { return heard_; }

  /// Listens for at most so long. True as soon as the run has said something new.
  bool listen(std::chrono::milliseconds most);
  /// Sends one request, with a counter above all that were taken and sent; session, sender, counter and time
  /// are this one's to fill in. A change is made once: it keeps its counter while none was taken since.
  /// Returns the counter.
  template <class Message>
  std::int64_t ask(Message request);
  /// Asks again after each `pause` until `enough(first)`, at most so long; `first`: counter of the first of
  /// these requests. Returns that.
  template <class Message>
  std::int64_t repeat(const Message& request, std::chrono::milliseconds pause, std::chrono::milliseconds most,
                      const std::function<bool(std::int64_t first)>& enough);
  /// Listens until `enough()`, at most until then. True when it was enough.
  bool listen_until(std::chrono::steady_clock::time_point end, const std::function<bool()>& enough);
  /// What the run has answered to the newest of this client's requests from `first` on; nothing yet
  /// otherwise.
  std::optional<Status> answer(std::int64_t first) const;
  /// True when one of them was admitted.
  bool is_admitted(std::int64_t first) const { return answer(first) == Status::ok; }
  /// A value of the task's output, or of a parameter, as the newest message has it; 0 when it is not in it.
  double value(const std::string& name) const;
  /// True when the newest message tells the task's state at all.
  bool has_state() const { return !heard_.state.empty(); }
  std::uint64_t sent() const { return sent_; }

 private:
  using Heard = drivers::ParametersMessage;  // of a task: what all answers have
  struct Search;
  const drivers::SipKey* key() const { return key_ ? &*key_ : nullptr; }
  Status read(std::span<const std::uint8_t> payload, const drivers::SipKey* key, Heard& heard) const;
  void note(const drivers::Lc02Message& message, Search& search) const;
  void listen_around(Search& search, std::chrono::milliseconds most);
  std::string missing(const Search& search) const;
  void count_on();

  std::string url_;
  drivers::LcmReceiver receiver_;
  drivers::LcmPublisher publisher_;
  std::optional<drivers::SipKey> key_;
  firmware::RequestTopic topic_;
  std::string channel_;
  std::int64_t sender_;
  std::int64_t counter_{};
  std::uint64_t sent_{};
  Heard heard_;
};

}  // namespace sortie::toolchain
