// SPDX-License-Identifier: BSD-3-Clause
// Messages of names and numbers that are put together at run time: job timing, and fields_t from a list.
// For threads that are not real-time; encoders do not allocate, decoders never more than the message is long.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/wire_fields.hpp"
#include "drivers/wire_telemetry.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// timing_t: when a job began, on the run's clock, and how long each of its tasks took.
struct JobTiming {
  std::int64_t tick{};
  std::int32_t group{};
  std::int64_t started_ns{};
  std::span<const std::uint32_t> duration_ns;
};

/// timing_t as read back.
struct JobTimingRecord {
  std::int64_t tick{};
  std::int32_t group{};
  std::int64_t started_ns{};
  std::vector<std::int64_t> duration_ns;
};

struct TimingRules : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("tick", self.tick);
    visit("group", self.group);
    visit("started_ns", self.started_ns);
    visit("duration_ns", listed<std::int64_t>("ntasks", self.duration_ns));
  }
};
template <>
struct WireRules<JobTiming> : TimingRules {};
template <>
struct WireRules<JobTimingRecord> : TimingRules {};

/// fields_t from names and values. Status: ok, full (`size` is then 0).
[[nodiscard]] inline Status encode_fields(std::int64_t utime, std::string_view task,
                                          std::span<const NamedValue> values, std::span<std::uint8_t> out,
                                          std::size_t& size) noexcept {
  return encode(FieldsView{utime, task, values}, out, size);
}

}  // namespace sortie::drivers
