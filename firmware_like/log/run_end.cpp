// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/run_end.hpp"

#include "firmware_like/log/log_event.hpp"

namespace sortie::firmware {

namespace {
constexpr const char* kRunEndKind = "end";
}  // namespace

void write_run_end(SampleSink& log, const rt::Executive& executive, rt::Tick ticks,
                   rt::Nanoseconds utc_minus_run_ns) {
  drivers::EventRecord event;
  event.tick = static_cast<std::int64_t>(ticks);
  event.kind = kRunEndKind;
  event.subject = "run";
  event.text = "the run had the ticks before this one";
  log_event(log, event, executive.time_of(ticks), utc_minus_run_ns);
}

std::optional<rt::Tick> run_end(const LogFile& log) {
  const std::vector<StoredEvent>& events = log.channel(std::string(drivers::kChannelEvent));
  // It stands among the last.
  for (auto stored = events.rbegin(); stored != events.rend(); ++stored) {
    drivers::EventRecord event;
    if (drivers::decode(stored->message, event) == Status::ok && event.kind == kRunEndKind && event.tick >= 0)
      return static_cast<rt::Tick>(event.tick);
  }
  return std::nullopt;
}

}  // namespace sortie::firmware
