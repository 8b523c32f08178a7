// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/result/results_live.hpp"

#include "firmware_like/scene/json_reader.hpp"

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
  for (const LiveTask& task : live.tasks) tasks.push_back(json_of(task));
  object["tasks"] = std::move(tasks);
  return object;
}

}  // namespace sortie::firmware
