// SPDX-License-Identifier: BSD-3-Clause
// Where requests to a drive or to a pilot come in. A refusal happens here, before anything is recorded, and
// is counted by its reason; what is admitted is judged once more by whoever obeys.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "firmware_like/link/request_reception.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "planner/request_gate.hpp"

namespace sortie::firmware {

/// What became of requests for motion; what is `full` was one in whose place a newer one came.
struct RequestDeskCounters : ReceptionCounters {
  std::uint64_t held_back{};  ///< waited too long in the queue of this computer
  std::uint64_t repeated{};   ///< played again, or overtaken by a later one
  std::uint64_t jumped{};     ///< its counter is too far ahead
  SORTIE_FIELDS(admitted, not_finite, out_of_range, full, malformed, bad_tag, wrong_session, wrong_time,
                held_back, repeated, jumped)
};

/// The desk of one kind of request for motion (that of changes: parameter_desk.hpp). What finds the stream
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

}  // namespace sortie::firmware
