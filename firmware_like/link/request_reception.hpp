// SPDX-License-Identifier: BSD-3-Clause
// What is the same at the desks of all kinds of requests: form, tag, robot and age, and what is answered.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "drivers/wire_requests.hpp"
#include "firmware_like/link/request_kind.hpp"
#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// When a request came, when it is taken, and how far its sender's clock may be from that: somebody may hold
/// back a datagram and let it go when it does harm, and a process that was stopped finds old ones in the
/// kernel's queue. The rule: age is judged when something is taken, never when it came in alone.
struct RequestAge {
  rt::Nanoseconds arrived_utc_ns{};  ///< when the kernel took the datagram
  rt::Nanoseconds taken_utc_ns{};    ///< now, of the same clock
  rt::Nanoseconds most_ns{};         ///< either way, since clocks differ either way; 0: not judged

  /// True when the sender's clock is judged at all.
  bool is_judged() const { return most_ns != 0; }
  /// Time in the kernel's queue. A clock that was set back meanwhile gives 0.
  rt::Nanoseconds waited_ns() const { return std::max<rt::Nanoseconds>(taken_utc_ns - arrived_utc_ns, 0); }
  /// `utime_us`: of the sender's clock, UTC; any value. Held against the moment of taking.
  bool fits(std::int64_t utime_us) const;
};

/// Who asks whom, and when.
struct RequestContext {
  const drivers::SipKey* key{};  ///< of the run, or null: anybody may ask
  std::int64_t session{};        ///< of the run; nobody guesses it, so it names one robot's one run
  rt::Nanoseconds now_ns{};      ///< the run's clock
  RequestAge age;
};

/// The newest answers, of bounded number; whoever was answered longest ago makes room.
class RequestAnswers {
 public:
  static constexpr std::size_t kMost = 16;

  /// Notes an answer beside all others.
  void add(const drivers::RequestAnswer& answer) {
    if (all.size() == kMost) all.erase(all.begin());
    all.push_back(answer);
  }
  /// Notes an answer in the place of its sender's last one. One that is older than that is dropped: whoever
  /// plays a request again must not turn its sender's answer into a refusal.
  void replace(const drivers::RequestAnswer& answer) {
    const auto last = std::find_if(all.begin(), all.end(),
                                   [&](const auto& other) { return other.sender == answer.sender; });
    if (last != all.end() && last->counter >= answer.counter) return;
    if (last != all.end()) all.erase(last);
    add(answer);
  }

  std::vector<drivers::RequestAnswer> all;
};

/// What became of requests; each kind has reasons of its own beside these.
struct ReceptionCounters {
  std::uint64_t admitted{};
  std::uint64_t not_finite{};
  std::uint64_t out_of_range{};   ///< what nobody can mean
  std::uint64_t full{};           ///< more at once than a job takes
  std::uint64_t malformed{};      ///< no request, or a damaged one
  std::uint64_t bad_tag{};        ///< from somebody who does not know the secret
  std::uint64_t wrong_session{};  ///< meant for another run
  /// Of a clock that is far from the run's; a parameter change also: waited too long here.
  std::uint64_t wrong_time{};
};

/// The front of a desk; `Counters`: ReceptionCounters and more. A refusal happens before anything is
/// recorded, and is counted by its reason. Not real-time.
template <class Counters>
class RequestReception {
 public:
  /// Any thread.
  Counters counters() const {
    const std::lock_guard lock(mutex_);
    return counters_;
  }

 protected:
  /// Reads a message; `mutex_` is held. False: it is no request to this run from one who may ask. That is
  /// counted and not answered, for a stranger learns nothing.
  template <class Message>
  bool open(std::span<const std::uint8_t> message, const RequestContext& context, Message& asked);

  mutable std::mutex mutex_;  // of what other threads read
  Counters counters_;
};

}  // namespace sortie::firmware
