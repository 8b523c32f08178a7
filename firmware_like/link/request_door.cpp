// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/request_door.hpp"

#include <unistd.h>

#include <algorithm>
#include <ctime>

#include "drivers/stop_filter.hpp"

namespace sortie::firmware {

namespace {

// A request for a parameter may have waited so long in the kernel's queue.
constexpr rt::Nanoseconds kMostWait_ns = 2 * rt::kNanosecondsPerSecond;

// Of the clock that stamps datagrams.
rt::Nanoseconds utc_now() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return std::int64_t{now.tv_sec} * rt::kNanosecondsPerSecond + std::int64_t{now.tv_nsec};
}

std::string computer_name() {
  char name[65] = {};  // HOST_NAME_MAX and its end
  return ::gethostname(name, sizeof name - 1) == 0 && *name != '\0' ? name : "robot";
}

}  // namespace

std::string RequestDoor::open(const std::string& url) {
  const ParameterAccess& access = runtime_.parameter_access();
  const bool drives = drive_.wanted() || fly_.wanted();
  const std::string verb = fly_.wanted() ? "fly the vehicle" : "drive the robot";
  const std::string what = access.remote && drives ? "set parameters and " + verb
                           : access.remote         ? "set parameters"
                                                   : verb;
  if (!access.remote && !drives) return {};
  if (url == "none" || url.empty())
    return std::string(access.remote   ? "[parameters]"
                       : fly_.wanted() ? "[flight]"
                                       : "[drive]") +
           " remote has no effect without an LCM address";
  robot_ = access.robot.empty() ? computer_name() : access.robot;
  if (!access.secret_file.empty()) key_ = read_secret(access.secret_file);
  if (!key_ && !access.without_secret)
    return "no requests are taken, for there is no secret: head -c 16 /dev/urandom | xxd -p > robot.secret "
           "&& "
           "chmod 600 robot.secret, then [parameters] secret_file = \"robot.secret\"; on a bench of your own "
           "without_secret = true lets anybody " +
           what;
  try {
    const std::int64_t session = unguessable_number();  // without one nobody could be told from a recording
    receiver_ = std::make_unique<drivers::LcmReceiver>(url);
    session_ = session;
  } catch (const std::exception& error) {
    return std::string("no requests are taken: ") + error.what();
  }
  std::string note;
  if (!key_) note = "anybody who reaches " + url + " can " + what + "; [parameters] secret_file closes that";
  try {
    if (drives) stops_ = std::make_unique<drivers::LcmReceiver>(url, drivers::stop_filter());
  } catch (const std::exception& error) {
    note += (note.empty() ? "" : "; ") + std::string("stops share the queue of all traffic: ") + error.what();
  }
  return note;
}

Status RequestDoor::set(std::string_view name, double value, rt::Nanoseconds now_ns) {
  Status status = Status::not_supported;
  if (const ParameterInfo* info = runtime_.parts().parameters().find(name); info != nullptr) {
    status = info->owner->table.check(name, value);
    rt::ParameterChange change;
    if (status == Status::ok) status = rt::make_change(name, value, now_ns, change);
    if (status == Status::ok) status = info->owner->port->push(change, now_ns);
  }
  const std::lock_guard lock(mutex_);
  ++version_;
  if (status == Status::ok) ++counters_.admitted;
  if (status == Status::not_supported) ++counters_.unknown;
  if (status == Status::not_finite) ++counters_.not_finite;
  if (status == Status::out_of_range) ++counters_.out_of_range;
  if (status == Status::full) ++counters_.full;
  return status;
}

void RequestDoor::run_script(rt::Nanoseconds now_ns) {
  const std::vector<ScriptLine>& script = runtime_.script();
  while (next_line_ < script.size() && script[next_line_].at_s * 1e9 <= static_cast<double>(now_ns)) {
    static_cast<void>(set(script[next_line_].name, script[next_line_].value, now_ns));  // counted
    ++next_line_;
  }
}

void RequestDoor::poll(rt::Nanoseconds now_ns) {
  run_script(now_ns);
  drive_.hand_in(now_ns);
  fly_.hand_in(now_ns);
  if (stops_) drain(*stops_, now_ns);
  if (receiver_) drain(*receiver_, now_ns);
}

void RequestDoor::drain(drivers::LcmReceiver& receiver, rt::Nanoseconds now_ns) {
  constexpr int kMostDatagrams = 256;  // a flood must not keep the script waiting
  drivers::ReceivedMessage received;
  for (int i = 0; i < kMostDatagrams; ++i) {
    const Status status = receiver.receive(received, 0);
    if (status == Status::empty || status == Status::disconnected) return;
    if (status != Status::ok) continue;
    const RequestContext context{
        key(),
        session_,
        now_ns,
        {received.stamp_ns, utc_now(), key_ ? runtime_.parameter_access().most_age_ns : 0}};
    if (received.message.channel == drivers::kChannelSet && runtime_.parameter_access().remote)
      take(received.message.payload, now_ns, context.age);
    if (received.message.channel == drivers::kChannelDrive) drive_.take(received.message.payload, context);
    if (received.message.channel == drivers::kChannelFly) fly_.take(received.message.payload, context);
  }
}

void RequestDoor::take(std::span<const std::uint8_t> message, rt::Nanoseconds now_ns, const RequestAge& age) {
  drivers::SetParameter request;
  const Status form = message.size() > drivers::kMaxSetParameterBytes
                          ? Status::malformed
                          : drivers::decode(message, key_ ? &*key_ : nullptr, request);
  {
    const std::lock_guard lock(mutex_);
    std::uint64_t* reason = nullptr;
    if (form == Status::disconnected) {
      reason = &counters_.bad_tag;
    } else if (form != Status::ok) {
      reason = &counters_.malformed;
    } else if (request.session != session_) {
      reason = &counters_.wrong_session;
    } else if (!age.fits(request.utime) || age.waited_ns() > kMostWait_ns) {
      reason = &counters_.wrong_time;
    } else if (request.counter <= newest_) {
      reason = &counters_.stale;
    }
    if (reason != nullptr) {
      ++*reason;
      return;  // not answered: a stranger learns nothing, and a repeat has had its answer
    }
    newest_ = request.counter;
  }
  const Status status = set(request.name, request.value, now_ns);
  const std::lock_guard lock(mutex_);
  if (answers_.size() == kAnswers) answers_.erase(answers_.begin());
  answers_.push_back({request.sender, request.counter, static_cast<std::int32_t>(status)});
  ++version_;
}

RequestDoorCounters RequestDoor::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

std::uint64_t RequestDoor::version() const {
  const std::lock_guard lock(mutex_);
  return version_;
}

drivers::ParametersMessage RequestDoor::describe() const {
  drivers::ParametersMessage message;
  message.session = session_;
  message.scene = runtime_.profile().name();
  message.remote = receiver_ != nullptr && runtime_.parameter_access().remote;
  message.keyed = key_.has_value();
  for (const ParameterInfo& info : runtime_.parts().parameters().all)
    message.parameters.push_back({info.name, info.unit, info.initial, info.low, info.high});
  const std::lock_guard lock(mutex_);
  message.counter = newest_;
  message.answers = answers_;
  return message;
}

}  // namespace sortie::firmware
