// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/parameter_desk.hpp"

namespace sortie::firmware {

void RequestDesk<drivers::SetParameter>::take(std::span<const std::uint8_t> message,
                                              const RequestContext& context) {
  constexpr rt::Nanoseconds kMostWait_ns = 2 * rt::kNanosecondsPerSecond;  // in the kernel's queue
  if (!wanted()) return;
  const std::lock_guard lock(mutex_);
  drivers::SetParameter asked;
  const bool is_long = message.size() > drivers::kMaxSetParameterBytes;
  if (!open(is_long ? message.first(0) : message, context, asked)) return;
  if (!context.age.fits(asked.utime) || context.age.waited_ns() > kMostWait_ns) {
    ++counters_.wrong_time;
  } else if (asked.counter <= newest_) {
    ++counters_.stale;
  } else {
    newest_ = asked.counter;
    const Status status = hand_in(asked.name, asked.value, context.now_ns);
    answers_.add({asked.sender, asked.counter, static_cast<std::int32_t>(status)});
  }
}

Status RequestDesk<drivers::SetParameter>::set(std::string_view name, double value, rt::Nanoseconds now_ns) {
  const std::lock_guard lock(mutex_);
  return hand_in(name, value, now_ns);
}

Status RequestDesk<drivers::SetParameter>::hand_in(std::string_view name, double value,
                                                   rt::Nanoseconds now_ns) {
  Status status = Status::not_supported;
  if (const ParameterInfo* info = runtime_.parts().parameters().find(name); info != nullptr) {
    status = info->owner->table.check(name, value);
    rt::ParameterChange change;
    if (status == Status::ok) status = rt::make_change(name, value, now_ns, change);
    if (status == Status::ok) status = info->owner->port->push(change, now_ns);
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
