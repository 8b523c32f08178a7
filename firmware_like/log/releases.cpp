// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/releases.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware_like/scene/input_error.hpp"

namespace sortie::firmware {
namespace {

constexpr std::uint64_t kMostSkipped = 1'000'000;  // in one gap: a damaged tick must not cost hours

std::uint64_t since(rt::Nanoseconds time, rt::Nanoseconds release) {
  return time > release ? static_cast<std::uint64_t>(time) - static_cast<std::uint64_t>(release) : 0;
}

}  // namespace

void ReleaseCounter::job(rt::Tick tick, rt::Nanoseconds started_ns, rt::Nanoseconds ended_ns, bool missed) {
  // A damaged log may name any tick: products wrap instead of overflowing.
  const auto release_of = [this](rt::Tick at) {
    return static_cast<rt::Nanoseconds>(static_cast<std::uint64_t>(rule_.epoch_ns) +
                                        at * static_cast<std::uint64_t>(rule_.base_tick_ns));
  };
  if ((jobs_ > 0 || rule_.from_start) && tick > next_ &&
      (tick - next_) / rule_.period_ticks <= kMostSkipped) {
    for (rt::Tick left_out = next_; left_out < tick; left_out += rule_.period_ticks) {
      lateness_.record(since(started_ns, release_of(left_out)));
      response_.record(since(ended_ns, release_of(left_out)));
      ++skipped_;
    }
  }
  next_ = tick + rule_.period_ticks;
  ++jobs_;
  missed_ += missed ? 1 : 0;
  lateness_.record(since(started_ns, release_of(tick)));
  response_.record(since(ended_ns, release_of(tick)));
}

GroupResult ReleaseCounter::result() const {
  const double tick_us = static_cast<double>(rule_.base_tick_ns) * 1e-3;
  GroupResult result;
  result.name = rule_.name;
  result.period_us = static_cast<double>(rule_.period_ticks) * tick_us;
  result.deadline_us = static_cast<double>(rule_.deadline_ticks) * tick_us;
  result.jobs = jobs_;
  result.missed = missed_;
  result.skipped = skipped_;
  put_times(result);
  return result;
}

bool read_timing(const StoredEvent& event, drivers::JobTimingRecord& timing) {
  if (drivers::decode(event.message, timing) != Status::ok || timing.group < 0 || timing.tick < 0)
    return false;
  return std::all_of(timing.duration_ns.begin(), timing.duration_ns.end(),
                     [](std::int64_t spent) { return spent >= 0 && spent <= 0xffffffff; });
}

std::vector<GroupResult> releases_of(const LogFile& log) {
  const drivers::LogHeader& header = log.header();
  if (header.utc_minus_monotonic_ns == 0)
    throw InputError(
        log.path() + ": was recorded in simulated time or imported, where nothing is late; record a live run",
        2);
  const std::int64_t tick_ns = std::max<std::int64_t>(header.base_tick_ns, 1);
  const double tick_us = static_cast<double>(tick_ns) * 1e-3;
  std::vector<ReleaseCounter> counters;
  const auto ticks_of = [tick_us](double us) {
    return static_cast<std::uint64_t>(std::llround(std::clamp(us / tick_us, 0.0, 1e15)));
  };
  std::istringstream groups(header.groups);
  for (std::string line; counters.size() < rt::kMaxGroups && std::getline(groups, line);) {
    std::istringstream words(line);
    std::string name;
    double period_us = 0;
    double phase_us = 0;
    double deadline_us = 0;
    words >> name >> period_us >> phase_us >> deadline_us;
    counters.emplace_back(ReleaseRule{name, tick_ns, header.epoch_ns,
                                      std::max<std::uint64_t>(ticks_of(period_us), 1), ticks_of(deadline_us),
                                      true, ticks_of(phase_us)});
  }
  bool some = false;
  for (const StoredEvent& event : log.channel(std::string(drivers::kChannelTiming))) {
    drivers::JobTimingRecord timing;
    if (!read_timing(event, timing)) continue;
    const auto group = static_cast<std::size_t>(timing.group);
    if (group >= counters.size()) continue;
    std::uint64_t end = static_cast<std::uint64_t>(timing.started_ns);  // of a damaged log it may wrap
    for (const std::int64_t duration : timing.duration_ns) end += static_cast<std::uint64_t>(duration);
    counters[group].job(static_cast<rt::Tick>(timing.tick), timing.started_ns,
                        static_cast<rt::Nanoseconds>(end), false);
    some = true;
  }
  if (!some)
    throw InputError(log.path() + ": holds no measured times; record a run with `sortie run --record`", 2);
  std::vector<GroupResult> results;
  results.reserve(counters.size());
  for (const ReleaseCounter& counter : counters) results.push_back(counter.result());
  return results;
}

std::vector<GroupResult> releases_of(const rt::posix::FlightReader& ring) {
  const rt::posix::FlightHeader& header = ring.header();
  std::vector<ReleaseCounter> counters;
  for (std::uint32_t i = 0; i < header.groups; ++i) {
    const rt::posix::FlightGroup& group = header.group[i];
    counters.emplace_back(ReleaseRule{group.name, header.base_tick_ns, header.epoch_ns, group.period_ticks,
                                      group.deadline_ticks});
  }
  for (const rt::posix::FlightJob& job : ring.jobs())
    counters[job.group].job(job.tick, job.started_ns, job.ended_ns(), job.verdict == rt::Verdict::missed);
  std::vector<GroupResult> results;
  results.reserve(counters.size());
  for (const ReleaseCounter& counter : counters) results.push_back(counter.result());
  return results;
}

}  // namespace sortie::firmware
