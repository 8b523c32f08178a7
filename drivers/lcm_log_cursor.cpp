// SPDX-License-Identifier: BSD-3-Clause
// Walks the events of a log in memory; every length is checked before it is used.
#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "drivers/lcm_log.hpp"
#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {
namespace {

struct Head {
  std::int64_t number{};
  std::int64_t timestamp_us{};
  std::uint32_t channel_bytes{};
  std::uint32_t data_bytes{};
};

// Null, or why there is no whole event at the start of `bytes` (not empty).
const char* find_fault(std::span<const std::uint8_t> bytes, Head& head) {
  if (std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte == 0; })) {
    return "zeros from here on: these bytes never reached the disk (power cut?)";
  }
  if (!begin_an_event(bytes)) return "there is no event here (sync word missing)";
  if (bytes.size() < kLcmLogHeaderBytes) return "the last event is cut off in its header";
  WireReader reader(bytes.subspan(4));
  head.number = reader.get<std::int64_t>();
  head.timestamp_us = reader.get<std::int64_t>();
  head.channel_bytes = reader.get<std::uint32_t>();
  head.data_bytes = reader.get<std::uint32_t>();
  if (head.channel_bytes == 0 || head.channel_bytes >= kLcmLogMaxChannel) {
    return "the event's channel length is impossible";
  }
  if (head.data_bytes > kLcmLogMaxData) return "the event's data length is impossible";
  if (head.channel_bytes + head.data_bytes > bytes.size() - kLcmLogHeaderBytes) {
    return "the event is cut off (longer than the rest of the log)";
  }
  return nullptr;
}

}  // namespace

bool begin_an_event(std::span<const std::uint8_t> bytes) noexcept {
  constexpr std::uint8_t kSync[4] = {0xED, 0xA1, 0xDA, 0x01};
  return std::memcmp(bytes.data(), kSync, bytes.size() < 4 ? bytes.size() : 4) == 0;
}

std::string LogProblem::describe() const {
  char text[256];
  std::snprintf(text, sizeof text,
                "byte %" PRIu64 ": %s (after %" PRIu64 " complete events, %" PRIu64 " bytes dropped)", offset,
                reason, event, skipped);
  return text;
}

Status LcmLogCursor::next(LogEvent& event) noexcept {
  if (position_ == bytes_.size()) return Status::empty;
  const auto rest = bytes_.subspan(position_);
  Head head;
  if (const char* reason = find_fault(rest, head); reason != nullptr) {
    problem_ = {position_, events_, rest.size(), reason};
    return Status::malformed;
  }
  const auto* channel = reinterpret_cast<const char*>(rest.data() + kLcmLogHeaderBytes);
  event.number = head.number;
  event.timestamp_us = head.timestamp_us;
  event.channel = {channel, head.channel_bytes};
  event.data = rest.subspan(kLcmLogHeaderBytes + head.channel_bytes, head.data_bytes);
  event.offset = position_;
  position_ += kLcmLogHeaderBytes + head.channel_bytes + head.data_bytes;
  ++events_;
  return Status::ok;
}

}  // namespace sortie::drivers
