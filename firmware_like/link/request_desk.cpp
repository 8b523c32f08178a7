// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/request_desk.hpp"

namespace sortie::firmware {

bool RequestAge::fits(std::int64_t utime_us) const {
  const std::int64_t taken_us = taken_utc_ns / rt::kNanosecondsPerMicrosecond;
  const std::int64_t most_us = most_ns / rt::kNanosecondsPerMicrosecond;
  return most_ns == 0 || (utime_us >= taken_us - most_us && utime_us <= taken_us + most_us);
}

template <class Counters>
template <class Message>
bool RequestReception<Counters>::open(std::span<const std::uint8_t> message, const RequestContext& context,
                                      Message& asked) {
  const Status form = drivers::decode(message, context.key, asked);
  if (form == Status::ok && asked.session == context.session) return true;
  ++(form == Status::ok             ? counters_.wrong_session
     : form == Status::disconnected ? counters_.bad_tag
                                    : counters_.malformed);
  return false;
}

template <class Message>
void RequestDesk<Message>::take(std::span<const std::uint8_t> message, const RequestContext& context) {
  if (!wanted()) return;
  const std::lock_guard lock(mutex_);
  hand_in_waiting(context.now_ns);
  Message form;
  if (!open(message, context, form)) return;
  const bool fits = context.age.fits(form.utime);
  const bool is_judged = context.age.is_judged();
  Asked asked{planner::plain<Request>(form), form.sender, fits && is_judged ? form.utime : 0, {}};
  asked.request.stamp_ns = context.now_ns - context.age.waited_ns();
  const bool stops = planner::stop_rank(asked.request) != 0;
  const bool at_any_age = stops && planner::stops_at_any_age(asked.request);
  // What could be a recording is taken in turn only.
  const bool is_of_now = at_any_age || is_judged || context.key == nullptr;
  asked.order = is_of_now ? planner::StopOrder::any : planner::StopOrder::rising;
  if (!at_any_age && !fits) {
    end(asked, Status::time_backwards);
  } else if (!stops && is_judged && form.utime <= stop_utime_) {
    // A release that was held back until a halt had come is older than that halt, whatever its counter.
    end(asked, Status::time_repeated);
  } else {
    admit(asked, context.now_ns);
  }
}

template <class Message>
void RequestDesk<Message>::hand_in(rt::Nanoseconds now_ns) {
  if (!wanted()) return;
  const std::lock_guard lock(mutex_);
  hand_in_waiting(now_ns);
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
  ++(status == Status::ok               ? counters_.admitted
     : status == Status::full           ? counters_.full
     : status == Status::time_backwards ? counters_.wrong_time
                                        : planner::refusal(counters_, status));
  const bool stops = planner::stop_rank(asked.request) != 0;
  (stops ? stop_answers_ : answers_)
      .replace({asked.sender, asked.request.counter, static_cast<std::int32_t>(status)});
}

template <class Message>
void RequestDesk<Message>::describe(drivers::AnswersMessage& message) const {
  const std::lock_guard lock(mutex_);
  message.task = Kind::kTopic.task;
  message.counter = gate_.newest;
  message.answers = stop_answers_.all;
  message.answers.insert(message.answers.end(), answers_.all.begin(), answers_.all.end());
}

template class RequestDesk<drivers::DriveRequestMessage>;
template class RequestDesk<drivers::FlyRequestMessage>;

void RequestDesk<drivers::SetParameter>::take(std::span<const std::uint8_t> message,
                                              const RequestContext& context) {
  constexpr rt::Nanoseconds kMostWait_ns = 2 * rt::kNanosecondsPerSecond;  // in the kernel's queue
  if (!wanted()) return;
  const std::lock_guard lock(mutex_);
  drivers::SetParameter asked;
  if (!open(message, context, asked)) return;
  if (!context.age.fits(asked.utime) || context.age.waited_ns() > kMostWait_ns) {
    ++counters_.wrong_time;
  } else if (asked.counter <= newest_) {
    ++counters_.stale;
  } else {
    newest_ = asked.counter;
    asked.change.stamp_ns = context.now_ns;
    const Status status = hand_in(asked.change);
    answers_.add({asked.sender, asked.counter, static_cast<std::int32_t>(status)});
  }
}

Status RequestDesk<drivers::SetParameter>::set(std::string_view name, double value, rt::Nanoseconds now_ns) {
  rt::ParameterChange change;
  // A name that does not fit is no parameter's; the change then has none.
  static_cast<void>(rt::make_change(name, value, now_ns, change));
  const std::lock_guard lock(mutex_);
  return hand_in(change);
}

Status RequestDesk<drivers::SetParameter>::hand_in(const rt::ParameterChange& change) {
  const std::string_view name = rt::name_of(change);
  Status status = Status::not_supported;
  if (const ParameterInfo* info = runtime_.parts().parameters().find(name); info != nullptr) {
    status = info->owner->table.check(name, change.value);
    if (status == Status::ok) status = info->owner->port->push(change, change.stamp_ns);
  }
  ++(status == Status::ok              ? counters_.admitted
     : status == Status::not_supported ? counters_.unknown
     : status == Status::not_finite    ? counters_.not_finite
     : status == Status::full          ? counters_.full
                                       : counters_.out_of_range);
  return status;
}

void RequestDesk<drivers::SetParameter>::describe(drivers::ParametersMessage& message) const {
  const std::lock_guard lock(mutex_);
  message.counter = newest_;
  message.answers = answers_.all;
}

std::int64_t RequestDesk<drivers::SetParameter>::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

}  // namespace sortie::firmware
