// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/results_live.hpp"

#include "firmware_like/json_reader.hpp"

namespace sortie::firmware {

Json to_json(const LiveTimes& live) {
  Json object{{"known", live.known}};
  if (!live.known) {
    object["why_not"] = live.why_not;
    return object;
  }
  if (!live.why_no_causes.empty()) object["why_no_causes"] = live.why_no_causes;
  object["over_budget"] = live.over_budget;
  Json tasks = Json::array();
  for (const LiveTask& task : live.tasks) {
    tasks.push_back(Json{{"name", task.name},
                         {"count", task.count},
                         {"p50_us", json_number(task.p50_us)},
                         {"p99_us", json_number(task.p99_us)},
                         {"p999_us", json_number(task.p999_us)},
                         {"max_us", json_number(task.max_us)}});
  }
  object["tasks"] = std::move(tasks);
  return object;
}

LiveTimes live_from_json(const Json& object) {
  const JsonReader in(object, "results: live: ");
  LiveTimes live;
  in.read("known", live.known);
  in.read("why_not", live.why_not);
  in.read("why_no_causes", live.why_no_causes);
  in.read("over_budget", live.over_budget);
  in.list("tasks", [&live](const Json& entry) {
    const JsonReader one(entry, "results: live: tasks: ");
    LiveTask task;
    one.read("name", task.name);
    one.read("count", task.count);
    one.read("p50_us", task.p50_us);
    one.read("p99_us", task.p99_us);
    one.read("p999_us", task.p999_us);
    one.read("max_us", task.max_us);
    live.tasks.push_back(std::move(task));
  });
  return live;
}

}  // namespace sortie::firmware
