// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log_feed.hpp"

#include <algorithm>
#include <cstring>

#include "firmware_like/importers/input_error.hpp"

namespace sortie::firmware {

namespace {

// What a job's record can hold. A damaged event may say anything.
bool fits_job_record(const drivers::TickRecord& tick) {
  if (tick.streams.size() > rt::kMaxStreamsPerGroup || tick.channels.size() > rt::kMaxInputsPerGroup ||
      tick.tasks.size() > rt::kMaxTasksPerGroup || tick.fields.size() > rt::kMaxFieldBytes || tick.tick < 0 ||
      tick.level < 0 || tick.level > rt::kTopLevel || tick.job < 0 || tick.group < 0 ||
      tick.group >= static_cast<std::int32_t>(rt::kMaxGroups)) {
    return false;
  }
  return std::all_of(tick.streams.begin(), tick.streams.end(),
                     [](const auto& stream) { return stream.count >= 0 && stream.first_seq >= 0; });
}

}  // namespace

bool to_job_record(const drivers::TickRecord& tick, rt::JobRecord& record) {
  if (!fits_job_record(tick)) return false;
  record.tick = static_cast<rt::Tick>(tick.tick);
  record.job = static_cast<std::uint64_t>(tick.job);
  record.group = static_cast<std::uint16_t>(tick.group);
  record.verdict = static_cast<rt::Verdict>(tick.verdict);
  record.level = static_cast<std::uint8_t>(tick.level);
  record.shed = static_cast<std::uint16_t>(tick.shed);
  record.cut = static_cast<std::uint16_t>(tick.cut);
  record.streams = static_cast<std::uint8_t>(tick.streams.size());
  record.inputs = static_cast<std::uint8_t>(tick.channels.size());
  record.tasks = static_cast<std::uint8_t>(tick.tasks.size());
  for (std::size_t i = 0; i < tick.streams.size(); ++i) {
    record.stream[i] = {static_cast<std::uint64_t>(tick.streams[i].first_seq),
                        static_cast<std::uint32_t>(tick.streams[i].count),
                        static_cast<std::uint16_t>(tick.streams[i].stream_id)};
  }
  for (std::size_t i = 0; i < tick.channels.size(); ++i)
    record.input[i] = {tick.channels[i].first, tick.channels[i].last};
  for (std::size_t i = 0; i < tick.tasks.size(); ++i) {
    record.digest[i] = tick.tasks[i].digest;
    record.units[i] = static_cast<std::uint32_t>(tick.tasks[i].units);
  }
  record.field_bytes = static_cast<std::uint32_t>(tick.fields.size());
  if (!tick.fields.empty()) std::memcpy(record.fields, tick.fields.data(), tick.fields.size());
  return true;
}

LogFeed::LogFeed(const LogFile& log, Runtime& runtime, bool use_ticks)
    : path_(log.path()),
      runtime_(runtime),
      use_ticks_(use_ticks),
      groups_(runtime.executive().group_count()) {
  const rt::Executive& executive = runtime.executive();
  for (const auto& port : runtime.parts().ports()) {
    auto cursor = std::make_unique<PortCursor>();
    cursor->port = port.get();
    cursor->events = &log.channel(port->channel());
    cursor->use.channel = port->channel();
    cursor->use.there = cursor->events->size();
    ports_.push_back(std::move(cursor));
  }
  for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
    groups_[index].current = std::make_unique<rt::JobRecord>();
    for (const rt::StreamBase* stream : executive.group(index).streams) {
      for (const auto& cursor : ports_) {
        if (&cursor->port->stream() == stream) groups_[index].ports.push_back(cursor.get());
      }
    }
  }
  for (const auto& entry : log.channels()) {
    const std::string& name = entry.first;  // clang 14 cannot capture a structured binding
    const bool is_sample = name.rfind("SORTIE_", 0) != 0 && name != drivers::kChannelTruth &&
                           name != drivers::kChannelContacts && name != drivers::kChannelSensorTruth &&
                           name != drivers::kChannelCan && name != drivers::kChannelSslCommand;
    const bool is_used = std::any_of(ports_.begin(), ports_.end(),
                                     [&name](const auto& cursor) { return cursor->port->channel() == name; });
    if (is_sample && !is_used) unused_channels_.push_back(name);
  }

  if (!use_ticks_) {
    std::uint32_t slowest = 1;
    for (std::uint32_t i = 0; i < executive.group_count(); ++i)
      slowest = std::max(slowest, executive.group(i).timing.period);
    last_tick_ =
        rt::first_tick_at_or_after(log.last_sample_ns(), executive.epoch_ns(), executive.base_tick_ns()) +
        slowest;
    // One wrong time must not keep a replay busy for ever.
    constexpr rt::Nanoseconds kLongest = 366LL * 24 * 3600 * 1'000'000'000;
    if (last_tick_ > static_cast<rt::Tick>(kLongest / executive.base_tick_ns())) {
      throw InputError(
          log.path() + ": its samples end " + std::to_string(last_tick_) +
          " ticks after its epoch, more than a year; a receipt time or the header's epoch is wrong");
    }
    return;
  }
  index_jobs(log);
  leave_out_orphans();
  first_tick_ = ~rt::Tick{0};
  for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
    const GroupCursor& cursor = groups_[index];
    if (cursor.jobs.empty()) continue;
    first_tick_ = std::min(first_tick_, cursor.first_tick);
    last_tick_ = std::max(last_tick_,
                          executive.group(index).timing.release(static_cast<std::uint64_t>(cursor.newest)));
  }
  if (first_tick_ > last_tick_)
    throw InputError(log.path() + ": no jobs were recorded before the log ends; nothing to replay");
}

void LogFeed::index_jobs(const LogFile& log) {
  const rt::Executive& executive = runtime_.executive();
  for (const StoredEvent& event : log.channel(std::string(drivers::kChannelTick))) {
    const bool fits = drivers::decode(event.message, scratch_) == Status::ok && fits_job_record(scratch_) &&
                      static_cast<std::uint32_t>(scratch_.group) < groups_.size();
    const auto index = static_cast<std::uint32_t>(fits ? scratch_.group : 0);
    const rt::Group& group = executive.group(index);
    if (!fits || scratch_.channels.size() != group.inputs.size() ||
        scratch_.streams.size() != group.streams.size() || scratch_.tasks.size() != group.tasks.size() ||
        group.timing.release(static_cast<std::uint64_t>(scratch_.job)) !=
            static_cast<rt::Tick>(scratch_.tick)) {
      // The table of groups is the log's own, so this is damage inside an event, which nothing else can tell.
      const auto number =
          static_cast<std::size_t>(&event - log.channel(std::string(drivers::kChannelTick)).data());
      damage_ = log.path() + ": SORTIE_TICK event " + std::to_string(number) + " (" +
                std::to_string(event.timestamp_us) + " us) is damaged; everything before it is used";
      break;
    }
    const auto tick = static_cast<rt::Tick>(scratch_.tick);
    GroupCursor& cursor = groups_[index];
    if (tick >= log.whole_until() || scratch_.job <= cursor.newest) continue;
    if (cursor.jobs.empty()) cursor.first_tick = tick;
    cursor.newest = scratch_.job;
    const std::size_t inputs = scratch_.channels.size();
    for (std::size_t i = 0; i < inputs; ++i) {
      const std::int64_t before = cursor.jobs.empty() ? -1 : cursor.needs[cursor.needs.size() - inputs];
      cursor.needs.push_back(std::max(before, scratch_.channels[i].last));
    }
    cursor.jobs.push_back(event);
  }
}

// A log that breaks off may hold a job and not the job of another group whose output it took. Such a job
// cannot be run again, nor can those behind it; leaving them out may orphan others, so this goes on until
// nothing changes.
void LogFeed::leave_out_orphans() {
  const rt::Executive& executive = runtime_.executive();
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
      GroupCursor& cursor = groups_[index];
      const std::size_t inputs = executive.group(index).inputs.size();
      std::size_t whole = cursor.jobs.size();
      for (std::size_t i = 0; i < inputs; ++i) {
        const std::int64_t there =
            groups_[executive.group(index).inputs[static_cast<std::uint32_t>(i)]->writer_group()].newest;
        // `needs` never falls along the jobs, so the first that is not met is found by halving.
        std::size_t low = 0;
        while (low < whole) {
          const std::size_t half = low + (whole - low) / 2;
          if (cursor.needs[half * inputs + i] > there)
            whole = half;
          else
            low = half + 1;
        }
      }
      if (whole == cursor.jobs.size()) continue;
      jobs_left_out_ += cursor.jobs.size() - whole;
      cursor.jobs.resize(whole);
      cursor.newest = -1;
      if (whole > 0 && drivers::decode(cursor.jobs.back().message, scratch_) == Status::ok)
        cursor.newest = scratch_.job;
      changed = true;
    }
  }
}

std::size_t LogFeed::jobs_before(const GroupCursor& cursor, rt::Tick tick) const {
  const auto at = std::partition_point(cursor.jobs.begin(), cursor.jobs.end(), [&](const StoredEvent& event) {
    return drivers::decode(event.message, scratch_) == Status::ok &&
           static_cast<rt::Tick>(scratch_.tick) < tick;
  });
  return static_cast<std::size_t>(at - cursor.jobs.begin());
}

void LogFeed::end_before(rt::Tick end) {
  if (end == 0 || end > last_tick_) return;
  last_tick_ = end - 1;
  for (GroupCursor& cursor : groups_) cursor.jobs.resize(jobs_before(cursor, end));
}

void LogFeed::archive(rt::Archive& archive, rt::Tick tick) {
  archive.expect(use_ticks_ ? 1 : 0, "the log was taken by ticks in one case and by times in the other");
  archive.expect(ports_.size(), "another number of input channels");
  for (const auto& cursor : ports_) {
    std::uint64_t next = cursor->next;
    archive.value(next);
    if (next > cursor->events->size()) {
      next = 0;
      archive.fail(Status::malformed, "more samples were taken from a channel than the log holds");
    }
    cursor->next = static_cast<std::size_t>(next);
  }
  archive.value(missing_samples_);
  archive.value(damaged_samples_);
  archive.value(refused_samples_);
  if (!archive.is_reading()) return;
  for (GroupCursor& cursor : groups_) {
    cursor.next = jobs_before(cursor, tick);
    cursor.ready = false;
  }
}

bool LogFeed::load(GroupCursor& cursor) {
  if (cursor.ready) return true;
  if (cursor.next >= cursor.jobs.size()) return false;
  cursor.ready = drivers::decode(cursor.jobs[cursor.next].message, scratch_) == Status::ok &&
                 to_job_record(scratch_, *cursor.current);
  if (!cursor.ready) throw InputError(path_ + ": a SORTIE_TICK event is damaged; record the log again");
  ++cursor.next;
  return true;
}

bool LogFeed::prepare(std::uint32_t group, std::uint64_t job, rt::Tick tick, rt::JobOrder& order) {
  GroupCursor& cursor = groups_[group];
  const rt::Executive& executive = runtime_.executive();
  if (!use_ticks_) {
    for (PortCursor* port : cursor.ports) {
      for (std::uint32_t taken = 0; taken < port->port->stream().batch() && port->next < port->events->size();
           ++taken) {
        const rt::Nanoseconds received =
            (*port->events)[port->next].timestamp_us * rt::kNanosecondsPerMicrosecond;
        if (rt::first_tick_at_or_after(received, executive.epoch_ns(), executive.base_tick_ns()) > tick)
          break;
        push(*port);
      }
    }
    return true;
  }
  if (!load(cursor) || cursor.current->job != job) return false;
  cursor.ready = false;
  if (cursor.current->streams != cursor.ports.size() ||
      cursor.current->inputs != executive.group(group).inputs.size() ||
      cursor.current->tasks != executive.group(group).tasks.size()) {
    throw InputError(
        path_ + ": job " + std::to_string(job) + " of group " + executive.group(group).spec.name +
        " was recorded with other inputs or tasks than this scene has, or its record is damaged; "
        "replay the log with its own scene");
  }
  for (std::size_t i = 0; i < cursor.ports.size(); ++i) {
    PortCursor& port = *cursor.ports[i];
    const std::uint64_t end = cursor.current->stream[i].first + cursor.current->stream[i].count;
    while (port.next < end && port.next < port.events->size()) push(port);
    if (port.next < end) missing_samples_ += end - port.next;
  }
  order.recorded = cursor.current.get();
  return true;
}

}  // namespace sortie::firmware
