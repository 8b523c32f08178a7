// SPDX-License-Identifier: BSD-3-Clause
// Telemetry messages: any described struct as name/value pairs, run times of the tasks, use of the pools.
// For threads that are not real-time. Encoders do not allocate (`full` if `out` is too small, `size` then 0);
// decoders allocate, but never more than the message is long.
#pragma once

#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/channels.hpp"
#include "drivers/wire_fields.hpp"
#include "rt/describe.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// Run time of one task since start.
struct TaskTiming {
  std::string task;
  std::int64_t count{};
  std::int64_t missed{};
  double p50_us{};
  double p99_us{};
  double max_us{};
  double budget_us{};
  SORTIE_FIELDS(task, count, missed, p50_us, p99_us, max_us, budget_us)
};

/// Use of one pool since start.
struct PoolUse {
  std::string pool;
  std::int64_t capacity{};
  std::int64_t used{};
  std::int64_t high_water{};
  std::int64_t refused{};
  SORTIE_FIELDS(pool, capacity, used, high_water, refused)
};

/// exec_stats_t and pool_stats_t: rows of the above, in someone's list of them.
template <class Rows>
struct StatsMessage {
  std::int64_t utime{};  ///< us UTC
  Rows rows;
  static constexpr void fields(auto& self, auto&& visit) {
    visit("utime", self.utime);
    visit("n", self.rows);
  }
};

/// One number of a fields_t message.
struct NamedValue {
  std::string name;
  double value{};
  SORTIE_FIELDS(name, value)
};

/// fields_t, with its texts and values in someone's memory or its own.
template <class Text, class Values>
struct FieldsOf {
  std::int64_t utime{};
  Text task;
  Values values;
  static constexpr void fields(auto& self, auto&& visit) {
    visit("utime", self.utime);
    visit("task", self.task);
    visit("n", self.values);
  }
};
using FieldsView = FieldsOf<std::string_view, std::span<const NamedValue>>;
/// As read back.
using FieldsMessage = FieldsOf<std::string, std::vector<NamedValue>>;

/// exec_stats_t and pool_stats_t; utime in microseconds UTC.
[[nodiscard]] Status encode(std::int64_t utime, std::span<const TaskTiming> tasks,
                            std::span<std::uint8_t> out, std::size_t& size) noexcept;
[[nodiscard]] Status encode(std::int64_t utime, std::span<const PoolUse> pools, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, std::int64_t& utime,
                            std::vector<TaskTiming>& tasks);
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, std::int64_t& utime,
                            std::vector<PoolUse>& pools);

/// fields_t of any described struct: "name" or "name[index]" for every scalar, values as doubles (64-bit
/// integers lose bits beyond 2^53).
template <rt::Described T>
[[nodiscard]] Status encode_fields(std::int64_t utime, std::string_view task, const T& value,
                                   std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  std::int32_t count = 0;
  rt::for_each_scalar(value, [&count](const char*, int, auto) { ++count; });
  writer.put(kFingerprintFields);
  writer.put(utime);
  writer.put_string(task);
  writer.put(count);
  rt::for_each_scalar(value, [&writer](const char* name, int index, auto) {
    char text[64];
    const int length = index < 0 ? std::snprintf(text, sizeof text, "%s", name)
                                 : std::snprintf(text, sizeof text, "%s[%d]", name, index);
    const auto bytes = static_cast<std::size_t>(length < 0 ? 0 : length);
    writer.put_string({text, bytes < sizeof text ? bytes : sizeof text - 1});
  });
  rt::for_each_scalar(value,
                      [&writer](const char*, int, auto scalar) { writer.put(static_cast<double>(scalar)); });
  return writer.finish(size);
}

}  // namespace sortie::drivers
