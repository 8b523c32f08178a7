// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/recorded_job.hpp"

#include <algorithm>
#include <cstring>

namespace sortie::firmware {

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

rt::Tick most_ticks_of_a_log(const rt::Executive& executive) {
  constexpr rt::Nanoseconds kLongest = 366LL * 24 * 3600 * 1'000'000'000;
  return static_cast<rt::Tick>(kLongest / executive.base_tick_ns());
}

}  // namespace sortie::firmware
