// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/event_desk.hpp"

#include <cstdio>
#include <string>

#include "firmware_like/log/log_event.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

namespace {

constexpr const char* kLadder[] = {
    "every task runs again", "tasks of criticality C run at half measure", "tasks of criticality C are off",
    "tasks of criticality C are off, B run at half measure", "tasks of criticality C and B are off"};

std::string milliseconds(std::int64_t us) {
  return std::to_string(us / 1000) + "." + std::to_string(us / 100 % 10);
}

// The event as a record; `utc_minus_run_ns` turns its tick into a date.
drivers::EventRecord to_record(const rt::posix::LiveEvent& event, const rt::Executive& executive,
                               rt::Nanoseconds utc_minus_run_ns) {
  using Kind = rt::posix::LiveEventKind;
  const rt::Group& group = executive.group(event.group);
  const std::string task =
      event.task < group.tasks.size() ? group.tasks[event.task]->name() : std::string(group.spec.name);
  drivers::EventRecord record;
  record.utime = (executive.time_of(event.tick) + utc_minus_run_ns) / 1000;
  record.tick = static_cast<std::int64_t>(event.tick);
  record.value = event.value;
  record.subject = group.spec.name;
  switch (event.kind) {
    case Kind::ladder:
      record.kind = "ladder";
      record.subject = event.core < 0 ? "unpinned groups" : "core " + std::to_string(event.core);
      record.text = "level " + std::to_string(event.value) + ": " +
                    kLadder[event.value >= 0 && event.value < 4 ? event.value : 4];
      break;
    case Kind::stuck:
      record.kind = "stuck";
      record.subject = task;
      record.text = "runs for " + milliseconds(event.value) + " ms, longer than its period";
      break;
    case Kind::unstuck:
      record.kind = "unstuck";
      record.subject = task;
      record.text = "has ended after at least " + milliseconds(event.value) + " ms";
      break;
    case Kind::promise:
      record.kind = "promise";
      record.text = "fewer than " + std::to_string(group.spec.firm.m) + " of " +
                    std::to_string(group.spec.firm.k) + " releases were met";
      break;
    case Kind::stop:
      record.kind = "stop";
      record.text = "was late, and its overrun policy is to stop the run";
      break;
  }
  return record;
}

}  // namespace

void EventDesk::take(rt::posix::LiveRunner& runner) {
  rt::posix::LiveEvent event;
  for (int i = 0; i < 1024 && runner.poll_event(event); ++i) {
    write(to_record(event, runtime_.executive(), utc_minus_run_ns_),
          runtime_.executive().time_of(event.tick));
  }
}

void EventDesk::tell(const std::string& kind, const std::string& subject, const std::string& text,
                     rt::Nanoseconds now_ns) {
  drivers::EventRecord record;
  record.utime = (now_ns + utc_minus_run_ns_) / rt::kNanosecondsPerMicrosecond;
  record.tick = now_ns / runtime_.executive().base_tick_ns();
  record.kind = kind;
  record.subject = subject;
  record.text = text;
  write(record, now_ns);
  std::fprintf(stderr, "%s\n", text.c_str());
}

void EventDesk::write(const drivers::EventRecord& record, rt::Nanoseconds now_ns) {
  log_event(recorder_, record, now_ns, utc_minus_run_ns_);
  if (rt::kBuilt<"telemetry"> && telemetry_ != nullptr) telemetry_->tell(record);
  ring_.event(now_ns, static_cast<rt::Tick>(record.tick), record.text);
  ++count;
}

}  // namespace sortie::firmware
