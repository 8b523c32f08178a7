// SPDX-License-Identifier: BSD-3-Clause
// Results to JSON and back. The key order is the order of docs and of people's eyes, not of the alphabet.
#include "firmware_like/results.hpp"

#include "firmware_like/json_reader.hpp"

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
  Json object{{"name", task.name},
              {"group", task.group},
              {"period_us", json_number(task.period_us)},
              {"budget_us", json_number(task.budget_us)},
              {"count", task.count},
              {"missed", task.missed},
              {"p50_us", json_number(task.p50_us)},
              {"p99_us", json_number(task.p99_us)},
              {"p999_us", json_number(task.p999_us)},
              {"max_us", json_number(task.max_us)}};
  if (!task.digest.empty()) object["digest"] = task.digest;
  if (!task.histogram.empty()) object["histogram"] = to_json(task.histogram);
  return object;
}

Json to_json(const GroupResult& group) {
  Json object{{"name", group.name},
              {"period_us", json_number(group.period_us)},
              {"phase_us", json_number(group.phase_us)},
              {"deadline_us", json_number(group.deadline_us)},
              {"core", group.core},
              {"jobs", group.jobs},
              {"missed", group.missed},
              {"skipped", group.skipped},
              {"worst_in_row", group.worst_in_row},
              {"promises_broken", group.promises_broken}};
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

void read_bars(const JsonReader& in, const char* key, std::vector<HistogramBar>& histogram) {
  const Json* bars = in.find(key);
  if (bars == nullptr) return;
  for (const Json& bar : in.check(bars->is_array(), key, *bars, "a list")) {
    in.check(bar.is_array() && bar.size() == 3 && bar[2].is_number_unsigned(), key, bar, "[from, to, count]");
    histogram.push_back({in.figure(key, bar[0]), in.figure(key, bar[1]), bar[2].get<std::uint64_t>()});
  }
}

TaskResult task_from(const Json& object, const std::string& place) {
  const JsonReader in(object, place);
  TaskResult task;
  in.read("name", task.name);
  in.read("group", task.group);
  in.read("period_us", task.period_us);
  in.read("budget_us", task.budget_us);
  in.read("count", task.count);
  in.read("missed", task.missed);
  in.read("p50_us", task.p50_us);
  in.read("p99_us", task.p99_us);
  in.read("p999_us", task.p999_us);
  in.read("max_us", task.max_us);
  in.read("digest", task.digest);
  read_bars(in, "histogram", task.histogram);
  return task;
}

GroupResult group_from(const Json& object, const std::string& place) {
  const JsonReader in(object, place);
  GroupResult group;
  in.read("name", group.name);
  in.read("period_us", group.period_us);
  in.read("phase_us", group.phase_us);
  in.read("deadline_us", group.deadline_us);
  in.read("core", group.core);
  in.read("jobs", group.jobs);
  in.read("missed", group.missed);
  in.read("skipped", group.skipped);
  in.read("worst_in_row", group.worst_in_row);
  in.read("promises_broken", group.promises_broken);
  in.read("late_p50_us", group.late_p50_us);
  in.read("late_p99_us", group.late_p99_us);
  in.read("late_p999_us", group.late_p999_us);
  in.read("late_max_us", group.late_max_us);
  in.read("response_max_us", group.response_max_us);
  group.wake_known = in.find("spinning") != nullptr;
  in.read("spinning", group.spinning);
  in.read("margin_us", group.margin_us);
  in.read("stack_bytes", group.stack_bytes);
  if (const Json* delays = in.find("delays")) group.delays = delays_from_json(*delays, place + "delays: ");
  read_bars(in, "lateness", group.lateness);
  read_bars(in, "response", group.response);
  return group;
}

PoolResult pool_from(const Json& object, const std::string& place) {
  const JsonReader in(object, place);
  PoolResult pool;
  in.read("name", pool.name);
  in.read("capacity", pool.capacity);
  in.read("high_water", pool.high_water);
  in.read("refused", pool.refused);
  in.read("bytes", pool.bytes);
  return pool;
}

}  // namespace

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
  for (const PoolResult& pool : results.pools) {
    pools.push_back({{"name", pool.name},
                     {"capacity", pool.capacity},
                     {"high_water", pool.high_water},
                     {"refused", pool.refused},
                     {"bytes", pool.bytes}});
  }
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

Results results_from_json(const Json& object) {
  const JsonReader in(object, "results: ");
  Results results;
  in.read("digest", results.digest);
  in.read("ticks", results.ticks);
  in.read("scene", results.scene);
  in.read("vehicle", results.vehicle);
  in.read("duration_s", results.duration_s);
  in.read("speed", results.speed);
  in.read("machine", results.machine);
  in.read("compiler", results.compiler);
  if (const Json* errors = in.find("errors")) {
    for (const auto& [name, value] : in.check(errors->is_object(), "errors", *errors, "an object").items()) {
      results.errors[name] = in.figure(name.c_str(), value);
    }
  }
  if (const Json* tasks = in.find("tasks")) {
    for (const Json& task : in.check(tasks->is_array(), "tasks", *tasks, "a list")) {
      results.tasks.push_back(task_from(task, "results: tasks: "));
    }
  }
  if (const Json* groups = in.find("groups")) {
    for (const Json& group : in.check(groups->is_array(), "groups", *groups, "a list")) {
      results.groups.push_back(group_from(group, "results: groups: "));
    }
  }
  if (const Json* schedule = in.find("schedule")) results.schedule = schedule_from_json(*schedule);
  in.list("chains", [&results](const Json& chain) { results.chains.push_back(chain_from_json(chain)); });
  if (const Json* pools = in.find("pools")) {
    for (const Json& pool : in.check(pools->is_array(), "pools", *pools, "a list")) {
      results.pools.push_back(pool_from(pool, "results: pools: "));
    }
  }
  if (const Json* counters = in.find("counters")) {
    for (const auto& [name, value] :
         in.check(counters->is_object(), "counters", *counters, "an object").items()) {
      results.counters[name] =
          in.check(value.is_number_unsigned(), name.c_str(), value, "a count").get<std::uint64_t>();
    }
  }
  in.read("profile_hash", results.profile_hash);
  in.read("left_out", results.left_out);
  in.read("warnings", results.warnings);
  if (const Json* live = in.find("live")) results.live = live_from_json(*live);
  if (const Json* doctor = in.find("doctor")) results.doctor = doctor_from_json(*doctor);
  return results;
}

}  // namespace sortie::firmware
