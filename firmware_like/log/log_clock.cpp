// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/log_clock.hpp"

#include <fstream>
#include <optional>

#include "firmware_like/log/log_event.hpp"
#include "firmware_like/scene/input_error.hpp"

namespace sortie::firmware {

namespace {

constexpr const char* kClockKind = "clock";

std::string boot_id() {
  std::ifstream in("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(in, id);
  return id.empty() ? "unknown" : id;
}

std::optional<drivers::EventRecord> find_clock(const LogFile& log) {
  const std::vector<drivers::EventRecord> clocks = events_of(log, kClockKind);
  return clocks.empty() ? std::nullopt : std::optional(clocks.front());
}

// What a log holds may be anything; sums of it must not overflow.
std::int64_t difference(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

}  // namespace

void write_log_clock(SampleSink& log, rt::Nanoseconds zero_ns, rt::Nanoseconds utc_minus_log_ns) {
  drivers::EventRecord event;
  event.kind = kClockKind;
  event.subject = boot_id();
  event.value = zero_ns;
  event.text = "CLOCK_MONOTONIC at time 0 of this log [ns], counted from that start of the machine";
  log_event(log, event, 0, utc_minus_log_ns);
}

ClockOffset clock_offset(const LogFile& run, const LogFile& other) {
  const auto a = find_clock(run);
  const auto b = find_clock(other);
  if (a && b && a->subject == b->subject && a->subject != "unknown")
    return {difference(b->value, a->value), true};
  const std::int64_t utc_a = run.header().utc_minus_monotonic_ns;
  const std::int64_t utc_b = other.header().utc_minus_monotonic_ns;
  if (utc_a == 0 || utc_b == 0) {
    throw InputError((utc_a == 0 ? run.path() : other.path()) +
                     ": does not say when it was recorded, so two logs cannot be laid side by side; a run in "
                     "simulated time holds its own truth");
  }
  return {difference(utc_b, utc_a), false};
}

TruthLog::TruthLog(const LogFile& run, const std::string& path)
    : log(path), offset(clock_offset(run, log)), poses(log.truth()) {
  if (poses.empty()) throw InputError(path + ": holds no truth; record one with `sortie plant --record`");
  for (TimedPose& pose : poses) pose.stamp_ns = difference(pose.stamp_ns, difference(0, offset.offset_ns));
  if (poses.back().stamp_ns < run.first_sample_ns() || poses.front().stamp_ns > run.last_sample_ns())
    throw InputError(path + ": its truth is of another time than " + run.path());
}

}  // namespace sortie::firmware
