// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/recorded_times.hpp"

#include <algorithm>

#include "drivers/wire_records.hpp"
#include "firmware_like/log/log_event.hpp"
#include "firmware_like/scene/json_reader.hpp"

namespace sortie::firmware {

namespace {

constexpr const char* kMeasuredKind = "measured";
constexpr const char* kRun = "run";  // subject of the run's own event; a group's is its name behind a slash

drivers::EventRecord measured_event(const std::string& subject, const Json& figures) {
  drivers::EventRecord event;
  event.kind = kMeasuredKind;
  event.subject = subject;
  event.text = figures.dump();
  return event;
}

void read_group(const Json& figures, GroupResult& group) {
  const JsonReader in(figures, "measured: ");
  in.read("spinning", group.spinning);
  in.read("margin_us", group.margin_us);
  in.read("stack_bytes", group.stack_bytes);
  group.wake_known = true;
  if (const Json* delays = in.find("delays")) group.delays = delays_from_json(*delays, "measured: delays: ");
}

void read_counters(const Json& figures, Results& results) {
  const JsonReader in(figures, "measured: ");
  for (const char* name : kLiveCounters) {
    if (in.find(name) == nullptr) continue;
    std::uint64_t value = 0;
    in.read(name, value);
    std::uint64_t& counter = results.counters[name];
    counter = std::max(counter, value);  // heap calls may have been on either machine
  }
}

}  // namespace

void write_measured(SampleSink& log, const Results& results, rt::Nanoseconds run_time_ns,
                    rt::Nanoseconds utc_minus_run_ns) {
  for (const GroupResult& group : results.groups) {
    Json figures{{"spinning", json_number(group.spinning)},
                 {"margin_us", json_number(group.margin_us)},
                 {"stack_bytes", group.stack_bytes}};
    if (group.delays.known) figures["delays"] = to_json(group.delays);
    log_event(log, measured_event("/" + group.name, figures), run_time_ns, utc_minus_run_ns);
  }
  Json counters = Json::object();
  for (const char* name : kLiveCounters) {
    if (const auto counter = results.counters.find(name); counter != results.counters.end())
      counters[name] = counter->second;
  }
  log_event(log, measured_event(kRun, counters), run_time_ns, utc_minus_run_ns);
}

std::string why_no_times(const LogFile& log) {
  if (!log.header().has_ticks)
    return "was imported, and no live run made it; record one with `sortie run --record`";
  if (log.header().utc_minus_monotonic_ns == 0)
    return "was recorded in simulated time, where nothing is late; record a live run";
  return {};
}

RecordedTimes::RecordedTimes(const LogFile& log, const Runtime& runtime, std::string why_not, bool whole)
    : log_(log), runtime_(runtime), why_not_(std::move(why_not)), whole_(whole) {
  if (!why_not_.empty()) return;
  const rt::Executive& executive = runtime.executive();
  groups_.resize(executive.group_count());
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    const rt::Group& group = executive.group(i);
    groups_[i].tasks.resize(group.tasks.size());
    releases_.emplace_back(ReleaseRule{group.spec.name, executive.base_tick_ns(), executive.epoch_ns(),
                                       group.timing.period, group.timing.deadline, whole,
                                       group.timing.phase});
  }
  drivers::JobTimingRecord timing;
  for (const StoredEvent& event : log.channel(std::string(drivers::kChannelTiming))) {
    if (read_timing(event, timing) && static_cast<std::size_t>(timing.group) < groups_.size())
      groups_[static_cast<std::size_t>(timing.group)].events.push_back(&event);
  }
}

const JobTimes* RecordedTimes::find(const rt::JobRecord& record) {
  if (!why_not_.empty()) return nullptr;
  GroupTimes& group = groups_[record.group];
  drivers::JobTimingRecord timing;
  while (group.next < group.events.size() && read_timing(*group.events[group.next], timing) &&
         static_cast<rt::Tick>(timing.tick) < record.tick)
    ++group.next;
  if (group.next == group.events.size() || static_cast<rt::Tick>(timing.tick) != record.tick ||
      timing.duration_ns.size() != group.tasks.size())
    return nullptr;
  group.current = {timing.started_ns, std::move(timing.duration_ns)};
  return &group.current;
}

void RecordedTimes::count(const rt::JobRecord& record, const JobTimes* times) {
  if (!why_not_.empty()) return;
  GroupTimes& group = groups_[record.group];
  ++group.jobs;
  group.without_is_last = times == nullptr;
  if (times == nullptr) {
    ++group.without;
    return;
  }
  rt::Nanoseconds ended = times->started_ns;
  for (std::size_t i = 0; i < times->duration_ns.size(); ++i) {
    const auto spent = static_cast<std::uint64_t>(times->duration_ns[i]);
    ended = static_cast<rt::Nanoseconds>(static_cast<std::uint64_t>(ended) + spent);  // wraps
    if ((record.shed >> i & 1) != 0) continue;                                        // left out: nothing ran
    group.tasks[i].record(spent);
    const rt::Group& declared = runtime_.executive().group(record.group);
    if (spent > std::uint64_t{declared.tasks[static_cast<std::uint32_t>(i)]->budget_us()} * 1000u)
      ++over_budget_;
  }
  releases_[record.group].job(record.tick, times->started_ns, ended, record.verdict == rt::Verdict::missed);
}

void RecordedTimes::add_to(Results& results) const {
  LiveTimes& live = results.live;
  live = {};
  live.why_not = why_not_;
  for (std::size_t i = 0; live.why_not.empty() && i < groups_.size(); ++i) {
    // A log that breaks off may have lost the times of its very last job.
    const std::uint64_t accepted = groups_[i].without_is_last ? 1 : 0;
    if (groups_[i].without > accepted) {
      live.why_not = "holds the times of only " + std::to_string(groups_[i].jobs - groups_[i].without) +
                     " of " + std::to_string(groups_[i].jobs) + " jobs of group " + results.groups[i].name +
                     "; record the run again";
    }
  }
  if (!live.why_not.empty()) {
    live.why_not = log_.path() + " " + live.why_not;
    return;
  }
  live.known = true;
  live.over_budget = over_budget_;
  const auto us = [](std::uint64_t ns) { return static_cast<double>(ns) * 1e-3; };
  const rt::Executive& executive = runtime_.executive();
  std::vector<std::size_t> place(groups_.size());
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    const std::uint16_t group = executive.task(i).group();
    const rt::LatencyHistogram& wall = groups_[group].tasks[place[group]++];
    live.tasks.push_back({executive.task(i).name(), wall.count(), us(wall.percentile(0.5)),
                          us(wall.percentile(0.99)), us(wall.percentile(0.999)), us(wall.max())});
  }
  for (std::size_t i = 0; i < releases_.size(); ++i) releases_[i].put_times(results.groups[i]);
  add_measured(results);
}

// Counters are those of the whole run in any case; wake-ups and causes are, too, so a part has none.
void RecordedTimes::add_measured(Results& results) const {
  std::string& why = results.live.why_no_causes;
  why = log_.path() +
        " ends before its run told wake-ups and causes: it was killed, or an older version made it";
  for (const drivers::EventRecord& event : events_of(log_, kMeasuredKind)) {
    try {
      const Json figures = Json::parse(event.text);
      if (event.subject == kRun) {
        read_counters(figures, results);
        why.clear();  // it is the last of them
      }
      for (GroupResult& group : results.groups) {
        if (whole_ && event.subject == "/" + group.name) read_group(figures, group);
      }
    } catch (const std::exception&) {
      why = log_.path() + ": what it tells of wake-ups and causes is damaged; record again";
      return;
    }
  }
  if (!whole_)
    why = log_.path() + " holds wake-ups and causes of the whole run only; leave out --from and --to";
}

}  // namespace sortie::firmware
