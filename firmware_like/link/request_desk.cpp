// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/request_desk.hpp"

#include <algorithm>

namespace sortie::firmware {

namespace {

rt::DriveRequest to_request(const drivers::DriveRequestMessage& asked) {
  rt::DriveRequest request;
  request.counter = asked.counter;
  request.speed_m_s = asked.speed_m_s;
  request.turn_rad_s = asked.turn_rad_s;
  request.mode = static_cast<std::uint32_t>(asked.mode);
  request.posture = asked.posture;
  request.flags = static_cast<std::uint32_t>(asked.flags);
  return planner::plain(request);
}

rt::FlyRequest to_request(const drivers::FlyRequestMessage& asked) {
  rt::FlyRequest request;
  request.counter = asked.counter;
  request.p_world_m[0] = asked.x_m;
  request.p_world_m[1] = asked.y_m;
  request.p_world_m[2] = asked.z_m;
  request.yaw_rad = asked.yaw_rad;
  request.mode = static_cast<std::uint32_t>(asked.mode);
  return planner::plain(request);
}

}  // namespace

template <class Message>
void RequestDesk<Message>::take(std::span<const std::uint8_t> message, const RequestContext& context) {
  if (!wanted()) return;
  const std::lock_guard lock(mutex_);
  hand_in_waiting(context.now_ns);
  Asked asked;
  const Verdict verdict = read(message, context, asked);
  if (verdict.counter != nullptr) {
    ++(counters_.*verdict.counter);
    if (verdict.answered) answer(asked, verdict.status);
    return;
  }
  admit(asked, context.now_ns);
}

template <class Message>
void RequestDesk<Message>::hand_in(rt::Nanoseconds now_ns) {
  if (!wanted()) return;
  const std::lock_guard lock(mutex_);
  hand_in_waiting(now_ns);
}

// Form, tag, robot and time. Without a counter the request may be admitted.
template <class Message>
auto RequestDesk<Message>::read(std::span<const std::uint8_t> message, const RequestContext& context,
                                Asked& asked) const -> Verdict {
  Message form;
  const Status read = drivers::decode(message, context.key, form);
  if (read == Status::disconnected) return {&RequestDeskCounters::bad_tag};
  if (read != Status::ok) return {&RequestDeskCounters::malformed};
  if (form.session != context.session) return {&RequestDeskCounters::wrong_session};
  asked.request = to_request(form);
  asked.request.stamp_ns = context.now_ns - context.age.waited_ns();
  asked.sender = form.sender;
  const bool fits = context.age.fits(form.utime);
  asked.utime = fits && context.age.is_judged() ? form.utime : 0;
  const bool stops = planner::stop_rank(asked.request) != 0;
  const bool at_any_age = stops && planner::stops_at_any_age(asked.request);
  if (!at_any_age && !fits) return {&RequestDeskCounters::wrong_time, true, Status::time_backwards};
  // A release that was held back until a halt had come is older than that halt, whatever its counter.
  if (!stops && context.age.is_judged() && form.utime <= stop_utime_)
    return {&RequestDeskCounters::repeated, true, Status::time_repeated};
  // What could be a recording is taken in turn only.
  const bool is_of_now = at_any_age || context.age.is_judged() || context.key == nullptr;
  asked.order = is_of_now ? planner::StopOrder::any : planner::StopOrder::rising;
  return {};
}

template <class Message>
void RequestDesk<Message>::admit(const Asked& asked, rt::Nanoseconds now_ns) {
  planner::RequestGate after = gate_;
  Status status = after.take(asked.request, entry_.rules, now_ns, asked.order);
  const bool is_outranked =
      waiting_ && planner::stop_rank(asked.request) < planner::stop_rank(waiting_->request);
  if (status == Status::ok && is_outranked) status = Status::full;
  if (status != Status::ok) {  // its counter can be used again
    end(asked, status);
    return;
  }
  gate_ = after;
  if (planner::stop_rank(asked.request) != 0) stop_utime_ = std::max(stop_utime_, asked.utime);
  if (waiting_) end(*waiting_, planner::stop_rank(waiting_->request) != 0 ? Status::ok : Status::full);
  waiting_ = asked;
  hand_in_waiting(now_ns);
}

template <class Message>
void RequestDesk<Message>::hand_in_waiting(rt::Nanoseconds now_ns) {
  if (!waiting_) return;
  const Asked asked = *waiting_;
  Status status = Status::ok;
  if (planner::stop_rank(asked.request) == 0 && entry_.rules.is_too_old(asked.request.stamp_ns, now_ns)) {
    status = Status::stale;
  } else {
    // Asked first: a stream counts what it refuses, and this one is no loss.
    const rt::StreamBase& stream = entry_.port->stream();
    if (stream.waiting() == stream.capacity()) return;
    status = entry_.port->push(asked.request, now_ns);
  }
  waiting_.reset();
  end(asked, status);
}

// Counts what became of a request, and answers it.
template <class Message>
void RequestDesk<Message>::end(const Asked& asked, Status status) {
  ++(status == Status::ok     ? counters_.admitted
     : status == Status::full ? counters_.full
                              : planner::refusal(counters_, status));
  answer(asked, status);
}

template <class Message>
void RequestDesk<Message>::answer(const Asked& asked, Status status) {
  answers_.note({asked.sender, asked.request.counter, static_cast<std::int32_t>(status)},
                planner::stop_rank(asked.request) != 0);
}

template <class Message>
RequestDeskCounters RequestDesk<Message>::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

template <class Message>
void RequestDesk<Message>::describe(drivers::AnswersMessage& message) const {
  const std::lock_guard lock(mutex_);
  message.task = RequestKind<Message>::kTask;
  message.counter = gate_.newest;
  message.answers = answers_.all();
}

template class RequestDesk<drivers::DriveRequestMessage>;
template class RequestDesk<drivers::FlyRequestMessage>;

}  // namespace sortie::firmware
