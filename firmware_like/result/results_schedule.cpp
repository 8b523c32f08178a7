// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/result/results_schedule.hpp"

#include "firmware_like/scene/json_reader.hpp"

namespace sortie::firmware {

Json to_json(const ScheduleResult& schedule) {
  Json groups = Json::array();
  for (const ScheduledGroup& group : schedule.groups) groups.push_back(json_of(group));
  Json cores = Json::array();
  for (const ScheduledCore& core : schedule.cores) {
    Json levels = Json::array();
    for (const double share : core.utilisation) levels.push_back(json_number(share));
    cores.push_back({{"core", core.core},
                     {"utilisation", std::move(levels)},
                     {"worst_tick_us", json_number(core.worst_tick_us)},
                     {"longest_block_us", json_number(core.longest_block_us)}});
  }
  Json object = json_of(schedule);
  object["groups"] = std::move(groups);
  object["cores"] = std::move(cores);
  object["findings"] = schedule.findings;
  return object;
}

Json to_json(const ChainResult& chain) {
  Json object = json_of(chain);
  if (chain.reaction.count + chain.age.count + chain.unmeasured == 0) return object;
  object["measured_reaction"] = json_of(chain.reaction);
  object["measured_age"] = json_of(chain.age);
  if (chain.finished.count != 0) object["measured_finished"] = json_of(chain.finished);
  object["source_interval_max_us"] = json_number(chain.source_interval_max_us);
  object["unmeasured"] = chain.unmeasured;
  return object;
}

}  // namespace sortie::firmware
