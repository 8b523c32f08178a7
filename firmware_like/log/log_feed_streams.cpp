// SPDX-License-Identifier: BSD-3-Clause
// What the feed of a log knows of its samples and of the digests beside them.
#include "firmware_like/log/log_feed.hpp"

namespace sortie::firmware {

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
      if (drivers::decode(event.message, scratch_) != Status::ok || scratch_.tasks.size() != tasks.size())
        continue;
      for (std::size_t i = 0; i < tasks.size(); ++i) {
        if ((static_cast<unsigned>(scratch_.shed) >> i & 1u) != 0) continue;  // it put out nothing
        std::uint64_t& chain = digest.tasks[tasks[i]];
        chain = rt::chain_digest(chain, static_cast<std::uint64_t>(scratch_.tick), scratch_.tasks[i].digest);
      }
      ++digest.jobs;
    }
  }
  for (std::uint32_t i = 0; i < executive.task_count(); ++i)
    digest.all = rt::chain_digest(digest.all, i, digest.tasks[i]);
  return digest;
}

}  // namespace sortie::firmware
