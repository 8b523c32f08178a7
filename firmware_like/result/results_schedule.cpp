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
  return {{"base_tick_us", json_number(schedule.base_tick_us)},
          {"hyperperiod_ticks", schedule.hyperperiod_ticks},
          {"harmonic", schedule.harmonic},
          {"schedulable", schedule.schedulable},
          {"groups", std::move(groups)},
          {"cores", std::move(cores)},
          {"findings", schedule.findings}};
}

Json to_json(const ChainResult& chain) {
  Json object{{"name", chain.name},
              {"path", chain.path},
              {"exact", chain.exact},
              {"reaction_us", json_number(chain.reaction_us)},
              {"age_us", json_number(chain.age_us)},
              {"max_reaction_us", json_number(chain.max_reaction_us)},
              {"max_age_us", json_number(chain.max_age_us)},
              {"source_interval_us", json_number(chain.source_interval_us)}};
  object["reactions_over"] = chain.reactions_over;
  object["ages_over"] = chain.ages_over;
  object["reaction_over_max_us"] = json_number(chain.reaction_over_max_us);
  object["age_over_max_us"] = json_number(chain.age_over_max_us);
  if (chain.reaction.count + chain.age.count + chain.unmeasured == 0) return object;
  object["measured_reaction"] = json_of(chain.reaction);
  object["measured_age"] = json_of(chain.age);
  if (chain.finished.count != 0) object["measured_finished"] = json_of(chain.finished);
  object["source_interval_max_us"] = json_number(chain.source_interval_max_us);
  object["unmeasured"] = chain.unmeasured;
  return object;
}

}  // namespace sortie::firmware
