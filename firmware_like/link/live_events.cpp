// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/live_events.hpp"

#include "rt/ladder.hpp"

namespace sortie::firmware {

namespace {

std::string ladder_text(std::int64_t level) {
  switch (level) {
    case 0:
      return "every task runs again";
    case 1:
      return "tasks of criticality C run at half measure";
    case 2:
      return "tasks of criticality C are off";
    case 3:
      return "tasks of criticality C are off, B run at half measure";
    default:
      return "tasks of criticality C and B are off";
  }
}

std::string milliseconds(std::int64_t us) {
  return std::to_string(us / 1000) + "." + std::to_string(us / 100 % 10);
}

}  // namespace

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
      record.text = "level " + std::to_string(event.value) + ": " + ladder_text(event.value);
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

}  // namespace sortie::firmware
