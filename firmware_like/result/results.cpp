// SPDX-License-Identifier: BSD-3-Clause
// Results to JSON and back. The key order is the order of docs and of people's eyes, not of the alphabet.
#include "firmware_like/result/results.hpp"

#include "firmware_like/scene/json_reader.hpp"

namespace sortie::firmware {
namespace {

Json to_json(const std::vector<HistogramBar>& histogram) {
  Json bars = Json::array();
  for (const HistogramBar& bar : histogram) {
    bars.push_back(Json::array({json_number(bar.from_us), json_number(bar.to_us), bar.count}));
  }
  return bars;
}

Json to_json(const TaskResult& task) {
  Json object = json_of(task);
  if (!task.digest.empty()) object["digest"] = task.digest;
  if (!task.histogram.empty()) object["histogram"] = to_json(task.histogram);
  return object;
}

Json to_json(const GroupResult& group) {
  Json object = json_of(group);
  if (group.lateness.empty()) return object;
  object["late_p50_us"] = json_number(group.late_p50_us);
  object["late_p99_us"] = json_number(group.late_p99_us);
  object["late_p999_us"] = json_number(group.late_p999_us);
  object["late_max_us"] = json_number(group.late_max_us);
  object["response_max_us"] = json_number(group.response_max_us);
  if (group.wake_known) {
    object["spinning"] = json_number(group.spinning);
    object["margin_us"] = json_number(group.margin_us);
    object["stack_bytes"] = group.stack_bytes;
  }
  if (group.delays.known) object["delays"] = to_json(group.delays);
  object["lateness"] = to_json(group.lateness);
  object["response"] = to_json(group.response);
  return object;
}

Json to_json(const LiveTimes& live) {
  Json object{{"known", live.known}};
  if (!live.known) {
    object["why_not"] = live.why_not;
    return object;
  }
  if (!live.why_no_causes.empty()) object["why_no_causes"] = live.why_no_causes;
  object["over_budget"] = live.over_budget;
  Json tasks = Json::array();
  for (const LiveTask& task : live.tasks) tasks.push_back(json_of(task));
  object["tasks"] = std::move(tasks);
  return object;
}

}  // namespace

std::vector<HistogramBar> bars_of(const rt::LatencyHistogram& histogram) {
  std::vector<HistogramBar> bars;
  histogram.for_each_bucket([&bars](std::uint64_t low, std::uint64_t high, std::uint64_t count) {
    bars.push_back({static_cast<double>(low) * 1e-3, static_cast<double>(high) * 1e-3, count});
  });
  return bars;
}

void set_releases(const rt::LatencyHistogram& lateness, const rt::LatencyHistogram& response,
                  GroupResult& group) {
  const auto us = [](std::uint64_t ns) { return static_cast<double>(ns) * 1e-3; };
  group.late_p50_us = us(lateness.percentile(0.5));
  group.late_p99_us = us(lateness.percentile(0.99));
  group.late_p999_us = us(lateness.percentile(0.999));
  group.late_max_us = us(lateness.max());
  group.response_max_us = us(response.max());
  group.lateness = bars_of(lateness);
  group.response = bars_of(response);
}

Json to_json(const Results& results) {
  Json errors = Json::object();
  for (const auto& [name, value] : results.errors) errors[name] = json_number(value);
  Json tasks = Json::array();
  for (const TaskResult& task : results.tasks) tasks.push_back(to_json(task));
  Json groups = Json::array();
  for (const GroupResult& group : results.groups) groups.push_back(to_json(group));
  Json chains = Json::array();
  for (const ChainResult& chain : results.chains) chains.push_back(to_json(chain));
  Json pools = Json::array();
  for (const PoolResult& pool : results.pools) pools.push_back(json_of(pool));
  Json counters = Json::object();
  for (const auto& [name, value] : results.counters) counters[name] = value;
  Json object{{"digest", results.digest},
              {"ticks", results.ticks},
              {"scene", results.scene},
              {"vehicle", results.vehicle},
              {"errors", std::move(errors)},
              {"tasks", std::move(tasks)},
              {"groups", std::move(groups)},
              {"schedule", to_json(results.schedule)},
              {"chains", std::move(chains)},
              {"pools", std::move(pools)},
              {"counters", std::move(counters)},
              {"duration_s", json_number(results.duration_s)},
              {"speed", json_number(results.speed)},
              {"machine", results.machine},
              {"compiler", results.compiler},
              {"profile_hash", results.profile_hash},
              {"left_out", results.left_out},
              {"warnings", results.warnings}};
  object["live"] = to_json(results.live);
  if (results.doctor.present) object["doctor"] = to_json(results.doctor);
  return object;
}

}  // namespace sortie::firmware
