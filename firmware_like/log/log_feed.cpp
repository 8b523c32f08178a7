// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/log_feed.hpp"

#include <algorithm>

#include "firmware_like/scene/input_error.hpp"

namespace sortie::firmware {

// The longest log that is replayed, a year: one wrong time must not keep a replay busy for ever.
rt::Tick LogFeed::most_ticks() const {
  constexpr rt::Nanoseconds kLongest = 366LL * 24 * 3600 * 1'000'000'000;
  return static_cast<rt::Tick>(kLongest / runtime_.executive().base_tick_ns());
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
    if (last_tick_ > most_ticks()) {
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
  take_run_end(log);
}

std::size_t LogFeed::jobs_before(const GroupCursor& cursor, rt::Tick tick) const {
  const auto at = std::partition_point(cursor.jobs.begin(), cursor.jobs.end(), [&](const StoredEvent& event) {
    return drivers::decode(event.message, scratch_) == Status::ok && scratch_.tick < tick;
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
  cursor.ready = drivers::decode(cursor.jobs[cursor.next].message, *cursor.current) == Status::ok;
  if (!cursor.ready) throw InputError(path_ + ": a SORTIE_TICK event is damaged; record the log again");
  ++cursor.next;
  return true;
}

void LogFeed::push(PortCursor& cursor) {
  const StoredEvent& event = (*cursor.events)[cursor.next++];
  const Status status =
      cursor.port->push_message(event.message, event.timestamp_us * rt::kNanosecondsPerMicrosecond);
  StreamUse& use = cursor.use;
  ++use.offered;
  if (status == Status::ok) ++use.taken;
  if (status == Status::malformed) ++use.malformed;
  if (status == Status::out_of_range) ++use.too_large;
  if (status == Status::full) ++use.no_room;
  if (status == Status::malformed) ++damaged_samples_;
  if (status == Status::full || status == Status::out_of_range) ++refused_samples_;
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
    if (port.next < end && end > port.asked) {
      missing_samples_ += end - std::max<std::uint64_t>(port.next, port.asked);
      port.asked = end;
    }
  }
  order.recorded = cursor.current.get();
  return true;
}

std::vector<StreamUse> LogFeed::stream_use() const {
  std::vector<StreamUse> uses;
  for (const auto& cursor : ports_) uses.push_back(cursor->use);
  return uses;
}

LogDigest LogFeed::recorded_digest() const {
  const rt::Executive& executive = runtime_.executive();
  LogDigest digest;
  if (!use_ticks_) return digest;
  digest.tasks.resize(executive.task_count());
  for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
    std::vector<std::uint32_t> tasks;
    for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
      if (executive.task(i).group() == index) tasks.push_back(i);
    }
    for (const StoredEvent& event : groups_[index].jobs) {
      if (drivers::decode(event.message, scratch_) != Status::ok || scratch_.tasks != tasks.size()) continue;
      for (std::size_t i = 0; i < tasks.size(); ++i) {
        if ((scratch_.shed >> i & 1) != 0) continue;  // it put out nothing
        std::uint64_t& chain = digest.tasks[tasks[i]];
        chain = rt::chain_digest(chain, scratch_.tick, scratch_.digest[i]);
      }
      ++digest.jobs;
    }
  }
  for (std::uint32_t i = 0; i < executive.task_count(); ++i)
    digest.all = rt::chain_digest(digest.all, i, digest.tasks[i]);
  return digest;
}

}  // namespace sortie::firmware
