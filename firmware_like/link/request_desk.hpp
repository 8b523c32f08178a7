// SPDX-License-Identifier: BSD-3-Clause
// Where requests to a drive or to a pilot come in, and changes of run-time parameters. A refusal happens
// here, before anything is recorded, and is counted by its reason; whoever obeys judges once more.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/wire_requests.hpp"
#include "firmware_like/link/request_kind.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "planner/request_gate.hpp"
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

/// What became of requests for motion; what is `full` was one in whose place a newer one came.
struct RequestDeskCounters : ReceptionCounters {
  std::uint64_t held_back{};  ///< waited too long in the queue of this computer
  std::uint64_t repeated{};   ///< played again, or overtaken by a later one
  std::uint64_t jumped{};     ///< its counter is too far ahead
  SORTIE_FIELDS(admitted, not_finite, out_of_range, full, malformed, bad_tag, wrong_session, wrong_time,
                held_back, repeated, jumped)
};

/// The desk of one kind of request for motion (that of changes follows below). What finds the stream
/// full waits here, one request of all: the newest takes the place of an older one, a stop that of everything
/// that does not outrank it, and nothing else a stop's. One thread calls take() and hand_in(); any thread may
/// read the rest.
template <class Message>
class RequestDesk : public RequestReception<RequestDeskCounters> {
 public:
  using Kind = RequestKind<Message>;
  using Request = typename Kind::Request;
  static constexpr const char* kCounters = "requests_";  ///< before their names in a result

  /// `entry`: of a vehicle that outlives the desk; without a port nothing is taken or counted.
  explicit RequestDesk(const RequestEntry<Request>& entry) : entry_(entry) {}

  /// True when the vehicle takes requests at all.
  bool wanted() const { return entry_.port != nullptr; }
  bool counts() const { return wanted(); }
  /// Judges the bytes of a message and hands the request in. A stranger learns nothing of it; who knows the
  /// secret finds its answer in describe().
  void take(std::span<const std::uint8_t> message, const RequestContext& context);
  /// Hands in what waits, if there is room by now. Call it as often as take() may be called.
  void hand_in(rt::Nanoseconds now_ns);

  /// Fills in the task that obeys, the highest counter that was taken, and the newest answers.
  void describe(drivers::AnswersMessage& message) const;

 private:
  struct Asked {
    Request request;
    std::int64_t sender{};
    std::int64_t utime{};  // of the sender's clock; 0 where that is not judged
    planner::StopOrder order{};
  };
  void admit(const Asked& asked, rt::Nanoseconds now_ns);
  void hand_in_waiting(rt::Nanoseconds now_ns);
  void end(const Asked& asked, Status status);

  RequestEntry<Request> entry_;
  planner::RequestGate gate_;
  std::optional<Asked> waiting_;
  std::int64_t stop_utime_{};  // when the newest stop was sent: nothing sent before it may undo it
  // One a sender. A stop's have a list of their own, so that no crowd of other senders can push them out.
  RequestAnswers stop_answers_;
  RequestAnswers answers_;
};

extern template class RequestDesk<drivers::DriveRequestMessage>;
extern template class RequestDesk<drivers::FlyRequestMessage>;

/// What became of the changes that were asked for.
struct ParameterDeskCounters : ReceptionCounters {
  std::uint64_t unknown{};  ///< no such parameter
  std::uint64_t stale{};    ///< repeated, or overtaken by a later one
  SORTIE_FIELDS(admitted, unknown, not_finite, out_of_range, full, malformed, bad_tag, wrong_session,
                wrong_time, stale)
};

/// The desk of changes. None stands for another, so none takes another's place: what finds no room is
/// refused. Each is judged once, whatever comes of it, and has an answer of its own; a repeat has had its.
/// One thread calls set() and take(); any thread may read the rest.
template <>
class RequestDesk<drivers::SetParameter> : public RequestReception<ParameterDeskCounters> {
 public:
  using Kind = RequestKind<drivers::SetParameter>;
  static constexpr const char* kCounters = "parameters_";  ///< before their names in a result

  /// `runtime` outlives the desk.
  explicit RequestDesk(Runtime& runtime) : runtime_(runtime) {}

  /// True when requests are taken; the script's changes always are.
  bool wanted() const { return runtime_.request_access().remote; }
  /// True when there is anything to change.
  bool counts() const { return !runtime_.parts().parameters().all.empty(); }
  /// Judges the bytes of a message and hands the change in.
  void take(std::span<const std::uint8_t> message, const RequestContext& context);
  /// Nothing waits here.
  void hand_in(rt::Nanoseconds) {}

  /// Hands in one change. Status: ok (it is in the log and will be applied by the group's next job),
  /// not_supported (no such parameter), not_finite, out_of_range, full. All counted.
  Status set(std::string_view name, double value, rt::Nanoseconds now_ns);

  /// Fills in the highest counter that was taken, and the newest answers.
  void describe(drivers::ParametersMessage& message) const;
  /// That counter: it has risen whenever there are new answers.
  std::int64_t newest() const;

 private:
  Status hand_in(const rt::ParameterChange& change);

  Runtime& runtime_;
  std::int64_t newest_{};
  RequestAnswers answers_;
};

}  // namespace sortie::firmware
