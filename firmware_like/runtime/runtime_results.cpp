// SPDX-License-Identifier: BSD-3-Clause
// What a runtime has to say of a run that has ended.
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

namespace {

GroupResult group_result(const rt::Executive& executive, const rt::Group& group) {
  const double tick_us = static_cast<double>(executive.base_tick_ns()) * 1e-3;
  GroupResult result;
  result.name = group.spec.name;
  result.period_us = group.timing.period * tick_us;
  result.phase_us = group.timing.phase * tick_us;
  result.deadline_us = group.timing.deadline * tick_us;
  result.core = group.spec.core;
  result.jobs = group.jobs;
  result.missed = group.missed;
  result.skipped = group.skipped;
  result.worst_in_row = group.misses.worst_in_row();
  result.promises_broken = group.misses.broken();
  set_releases(group.lateness, group.response, result);
  return result;
}

TaskResult task_result(const rt::Executive& executive, const rt::TaskBase& task) {
  const rt::Group& group = executive.group(task.group());
  const rt::LatencyHistogram& wall = task.wall_time();
  TaskResult result;
  result.name = task.name();
  result.group = group.spec.name;
  result.period_us =
      static_cast<double>(group.timing.period) * static_cast<double>(executive.base_tick_ns()) * 1e-3;
  result.budget_us = task.budget_us();
  result.count = wall.count();
  result.missed = group.missed;
  result.p50_us = static_cast<double>(wall.percentile(0.5)) * 1e-3;
  result.p99_us = static_cast<double>(wall.percentile(0.99)) * 1e-3;
  result.p999_us = static_cast<double>(wall.percentile(0.999)) * 1e-3;
  result.max_us = static_cast<double>(wall.max()) * 1e-3;
  result.digest = hex(task.chain());
  result.histogram = bars_of(wall);
  return result;
}

void add_pools(const Runtime& runtime, Results& results) {
  const auto plan = runtime.memory_plan();
  const auto bytes_of = [&plan](const std::string& name) -> std::uint64_t {
    for (const PoolResult& pool : plan) {
      if (pool.name == name) return pool.bytes;
    }
    return 0;
  };
  for (const auto& port : runtime.parts().ports()) {
    const rt::StreamBase& stream = port->stream();
    results.pools.push_back({port->channel(), stream.capacity(), stream.high_water(), stream.refused(),
                             bytes_of(port->channel())});
    results.counters["refused_samples"] += stream.refused();
  }
  for (const auto& [name, level] : runtime.parts().pools()) {
    const PoolLevel now = level();
    results.pools.push_back({name, now.capacity, now.high_water, now.refused, bytes_of(name)});
  }
}

}  // namespace

Results collect_results(const Runtime& runtime, std::uint64_t ticks) {
  const rt::Executive& executive = runtime.executive();
  Results results;
  results.digest = hex(executive.digest());
  results.ticks = ticks;
  results.scene = runtime.profile().name();
  results.vehicle = runtime.profile().vehicle();
  results.machine = machine_description();
  results.compiler = compiler_description();
  results.profile_hash = hex(runtime.profile().hash());
  results.left_out = runtime.parts().left_out();
  if (!runtime.outlets().telemetry) results.left_out.emplace_back("telemetry");
  if (!runtime.outlets().recorder) results.left_out.emplace_back("recorder");
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    const rt::TaskBase& task = executive.task(i);
    results.counters["over_budget"] += task.over_budget();
    results.counters["shed_jobs"] += task.shed();
    results.counters["cut_jobs"] += task.cut();
    results.tasks.push_back(task_result(executive, task));
  }
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    const rt::Group& group = executive.group(i);
    results.counters["jobs"] += group.jobs;
    results.counters["missed_jobs"] += group.missed;
    results.counters["skipped_releases"] += group.skipped;
    results.counters["promises_broken"] += group.misses.broken();
    results.groups.push_back(group_result(executive, group));
  }
  results.schedule = schedule_result(runtime.schedule(), executive);
  for (const DeclaredChain& chain : runtime.chains()) results.chains.push_back(chain_result(chain));
  results.warnings = runtime.schedule().warnings;
  add_pools(runtime, results);
  for (const auto& [name, value] : runtime.parts().counters()) results.counters[name] = value();
  for (const auto& group : runtime.parts().parameters().groups) {
    results.counters["parameters_applied"] += group->table.state().applied;
    results.counters["parameters_not_applied"] += group->table.state().refused;
  }
  return results;
}

}  // namespace sortie::firmware
