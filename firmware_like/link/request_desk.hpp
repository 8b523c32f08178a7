// SPDX-License-Identifier: BSD-3-Clause
// Where requests to a drive or to a pilot come in. A refusal happens here, before anything is recorded, and
// is counted by its reason; what is admitted is judged once more by whoever obeys.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <span>

#include "drivers/siphash.hpp"
#include "drivers/wire_fly.hpp"
#include "drivers/wire_requests.hpp"
#include "firmware_like/link/request_age.hpp"
#include "firmware_like/link/request_answers.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "planner/request_gate.hpp"
#include "rt/describe.hpp"

namespace sortie::firmware {

/// What became of requests.
struct RequestDeskCounters {
  std::uint64_t admitted{};
  std::uint64_t not_finite{};
  std::uint64_t out_of_range{};   ///< what nobody can mean
  std::uint64_t full{};           ///< more at once than a job takes: a newer one took its place
  std::uint64_t malformed{};      ///< no request, or a damaged one
  std::uint64_t bad_tag{};        ///< from somebody who does not know the secret
  std::uint64_t wrong_session{};  ///< meant for another run
  std::uint64_t wrong_time{};     ///< held back, or of a clock that is far from the run's
  std::uint64_t held_back{};      ///< waited too long in the queue of this computer
  std::uint64_t repeated{};       ///< played again, or overtaken by a later one
  std::uint64_t jumped{};         ///< its counter is too far ahead
  SORTIE_FIELDS(admitted, not_finite, out_of_range, full, malformed, bad_tag, wrong_session, wrong_time,
                held_back, repeated, jumped)
};

/// Who asks whom, and when.
struct RequestContext {
  const drivers::SipKey* key{};  ///< of the run, or null: anybody may ask
  std::int64_t session{};        ///< of the run; nobody guesses it, so it names one robot's one run
  rt::Nanoseconds now_ns{};      ///< the run's clock
  RequestAge age;
};

/// What a message becomes for the vehicle that obeys, and the task that does.
template <class Message>
struct RequestKind;
template <>
struct RequestKind<drivers::DriveRequestMessage> {
  using Request = rt::DriveRequest;
  static constexpr const char* kTask = "drive";
};
template <>
struct RequestKind<drivers::FlyRequestMessage> {
  using Request = rt::FlyRequest;
  static constexpr const char* kTask = "pilot";
};

/// The desk of one kind of request. What finds the stream full waits here, one request of all: the newest
/// takes the place of an older one, a stop that of everything that does not outrank it, and nothing else a
/// stop's. One thread calls take() and hand_in(); any thread may read the rest. Not real-time.
template <class Message>
class RequestDesk {
 public:
  using Request = typename RequestKind<Message>::Request;

  /// `entry`: of a vehicle that outlives the desk; without a port nothing is taken or counted.
  explicit RequestDesk(const RequestEntry<Request>& entry) : entry_(entry) {}

  /// True when the vehicle takes requests at all.
  bool wanted() const { return entry_.port != nullptr; }
  /// Judges the bytes of a message and hands the request in. A stranger learns nothing of it; who knows the
  /// secret finds its answer in answers().
  void take(std::span<const std::uint8_t> message, const RequestContext& context);
  /// Hands in what waits, if there is room by now. Call it as often as take() may be called.
  void hand_in(rt::Nanoseconds now_ns);

  RequestDeskCounters counters() const;
  /// Fills in the task that obeys, the highest counter that was taken, and the newest answers.
  void describe(drivers::AnswersMessage& message) const;

 private:
  struct Asked {
    Request request;
    std::int64_t sender{};
    std::int64_t utime{};  // of the sender's clock; 0 where that is not judged
    planner::StopOrder order{};
  };
  struct Verdict {
    std::uint64_t RequestDeskCounters::*counter{};  // of the reason; null: nothing speaks against it
    bool answered{};
    Status status{};
  };
  Verdict read(std::span<const std::uint8_t> message, const RequestContext& context, Asked& asked) const;
  void admit(const Asked& asked, rt::Nanoseconds now_ns);
  void hand_in_waiting(rt::Nanoseconds now_ns);
  void end(const Asked& asked, Status status);
  void answer(const Asked& asked, Status status);

  RequestEntry<Request> entry_;
  planner::RequestGate gate_;
  std::optional<Asked> waiting_;
  std::int64_t stop_utime_{};  // when the newest stop was sent: nothing sent before it may undo it
  mutable std::mutex mutex_;   // of what is read
  RequestDeskCounters counters_;
  RequestAnswers answers_;
};

extern template class RequestDesk<drivers::DriveRequestMessage>;
extern template class RequestDesk<drivers::FlyRequestMessage>;

}  // namespace sortie::firmware
