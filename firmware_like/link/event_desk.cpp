// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/event_desk.hpp"

#include <cstdio>
#include <string>

#include "firmware_like/link/live_events.hpp"
#include "firmware_like/log/log_event.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

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
