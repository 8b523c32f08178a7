// SPDX-License-Identifier: BSD-3-Clause
// Telemetry messages: outputs of a task as name/value pairs, run times of the tasks, use of the pools.
// encode() and decode() are those of wire_fields.hpp; for threads that are not real-time.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/wire_fields.hpp"
#include "rt/describe.hpp"

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

/// exec_stats_t and pool_stats_t: rows of the above.
template <class Row>
struct StatsMessage {
  std::int64_t utime{};  ///< us UTC
  std::vector<Row> rows;
  static constexpr void fields(auto& self, auto&& visit) {
    visit("utime", self.utime);
    visit("n", self.rows);
  }
};
using ExecStats = StatsMessage<TaskTiming>;
using PoolStats = StatsMessage<PoolUse>;

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

}  // namespace sortie::drivers
