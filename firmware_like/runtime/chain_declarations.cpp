// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/chain_declarations.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/runtime/vehicle.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "rt/chain_path.hpp"

namespace sortie::firmware {

namespace {

// Arrivals of a stream that are kept: enough for a recorder that is seconds behind.
constexpr std::uint32_t kArrivals = 1u << 14;

ChainSpec read_spec(Profile& profile, ChainSpec spec) {
  const std::string below = "chains." + spec.name + ".";
  spec.path = profile.texts(below + "path", spec.path, "a stream or a task, then tasks, by name");
  const auto read = [&](const char* key, double& value, const char* meaning) {
    value = profile.number(below + key, {value, 0, 1e6, "ms", meaning});
  };
  read("max_reaction_ms", spec.max_reaction_ms,
       "longest time from a sample to an output that knows of it; 0: any");
  read("max_age_ms", spec.max_age_ms, "oldest sample behind an output when it becomes visible; 0: any");
  read("source_interval_ms", spec.source_interval_ms,
       "longest time between two samples, max_age_ms of a stream needs it; 0: one comes for every release");
  return spec;
}

template <class Names>
std::string list(const Names& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + std::string(name);
  return text.empty() ? "nothing" : text;
}

// Why a path is no chain of this table, with what there is instead.
std::string explain(const rt::FoundPath& found, const ChainSpec& spec, const rt::Executive& executive) {
  const std::string step = found.step < spec.path.size() ? spec.path[found.step] : std::string();
  const auto task = [&executive](const std::string& name) -> const rt::TaskBase* {
    for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
      if (name == executive.task(i).name()) return &executive.task(i);
    }
    return nullptr;
  };
  std::vector<std::string> names;
  switch (found.fault) {
    case rt::PathFault::none:
      return {};
    case rt::PathFault::no_task:
      return spec.path.empty()
                 ? "a chain needs a path of at least one task, for example path = [\"IMU\", \"attitude\"]"
                 : "its path names a stream and no task: say which task the samples go to, for example path "
                   "= [\"" +
                       spec.path[0] + "\", \"attitude\"]";
    case rt::PathFault::unknown: {
      for (std::uint32_t i = 0; i < executive.stream_count() && found.step == 0; ++i)
        names.emplace_back(executive.stream(i).name());
      for (std::uint32_t i = 0; i < executive.task_count(); ++i) names.emplace_back(executive.task(i).name());
      return "\"" + step + "\" is no " + (found.step == 0 ? "stream or " : "") +
             "task of this scene; it has: " + list(names);
    }
    case rt::PathFault::not_consumed: {
      const rt::Group& group = executive.group(task(step)->group());
      for (const rt::StreamBase* stream : group.streams) names.emplace_back(stream->name());
      return "group " + std::string(group.spec.name) + " of task " + step + " does not consume " +
             spec.path[0] + "; it consumes: " + list(names);
    }
    case rt::PathFault::not_read: {
      const rt::Group& group = executive.group(task(step)->group());
      for (const rt::InputBase* input : group.inputs)
        names.emplace_back(executive.task(input->task()).name());
      return "group " + std::string(group.spec.name) + " of task " + step + " has no input from " +
             spec.path[found.step - 1] + "; it reads: " + list(names);
    }
    case rt::PathFault::too_long:
      return "the path is too long: at most " + std::to_string(rt::kMaxChainLegs) + " groups and " +
             std::to_string(rt::kMaxChainSteps) + " tasks";
  }
  return {};
}

std::string in_ms(std::uint64_t ns) { return format_short(static_cast<double>(ns) * 1e-6) + " ms"; }

void hold_to_bounds(Profile& profile, const DeclaredChain& declared, const rt::Executive& executive) {
  const std::string below = "chains." + declared.spec.name + ".";
  std::vector<std::string> groups;
  for (const rt::ChainLeg& leg : declared.chain.legs)
    groups.emplace_back(executive.group(leg.group).spec.name);
  const auto hold = [&](const char* key, const char* what, std::uint64_t worst_ns, double allowed_ms) {
    if (allowed_ms == 0 || static_cast<double>(worst_ns) <= allowed_ms * 1e6) return;
    profile.fail(below + key, std::string("the worst ") + what + " is " + in_ms(worst_ns) +
                                  ", above the allowed " + format_short(allowed_ms) +
                                  " ms: raise the rate or shorten deadline_ticks of the groups on the way (" +
                                  list(groups) + "), or allow more");
  };
  // Nothing but the declared interval says how old a sample grows before the next one comes.
  if (declared.chain.from_stream && declared.spec.max_age_ms > 0 && declared.spec.source_interval_ms == 0) {
    profile.fail(below + "max_age_ms", "the age of what comes from " + declared.spec.path.front() +
                                           " cannot be bounded: " + below +
                                           "source_interval_ms is missing, "
                                           "the longest time between two of its samples");
  }
  hold("max_reaction_ms", "reaction time", declared.bound.reaction_ns, declared.spec.max_reaction_ms);
  hold("max_age_ms", "data age", declared.bound.age_ns, declared.spec.max_age_ms);
}

// The bounds hold only if a job takes all samples that wait.
void check_batch(const DeclaredChain& declared, const rt::Executive& executive,
                 std::vector<std::string>& warnings) {
  if (!declared.chain.from_stream || declared.chain.source_interval_ns == 0) return;
  const rt::ChainLeg& first = declared.chain.legs[0];
  const rt::Group& group = executive.group(first.group);
  const auto period = static_cast<rt::Nanoseconds>(group.timing.period) * executive.base_tick_ns();
  const rt::Nanoseconds samples = period / declared.chain.source_interval_ns;
  const rt::StreamBase& stream = *group.streams[first.port];
  if (samples <= static_cast<rt::Nanoseconds>(stream.batch())) return;
  warnings.push_back("chain " + declared.spec.name + ": " + std::to_string(samples) + " samples of " +
                     stream.name() + " come for each release of group " + group.spec.name +
                     ", which takes at most " + std::to_string(stream.batch()) +
                     ": reaction time and age grow with the backlog");
}

}  // namespace

std::vector<DeclaredChain> read_chains(Profile& profile, VehicleBuilder& builder,
                                       const rt::Executive& executive, std::vector<std::string>& warnings) {
  std::vector<ChainSpec> specs = builder.chains();
  for (const std::string& name : profile.tables("chains")) {
    const bool known =
        std::any_of(specs.begin(), specs.end(), [&name](const ChainSpec& spec) { return spec.name == name; });
    if (!known) specs.push_back({name, {}, 0, 0, 0});
  }
  const rt::ScheduleTable table = rt::declared_table(executive);
  std::vector<DeclaredChain> chains;
  for (const ChainSpec& declared : specs) {
    DeclaredChain result;
    result.spec = read_spec(profile, declared);
    // Of a part that a what-if leaves out: its bounds are there, its path is not.
    if (result.spec.path.empty() && profile.text("scene.unknown_keys", "refuse", "") == "ignore") continue;
    std::vector<const char*> steps;
    for (const std::string& step : result.spec.path) steps.push_back(step.c_str());
    const rt::FoundPath found =
        rt::find_chain(executive, steps.data(), static_cast<std::uint32_t>(steps.size()));
    if (found.fault != rt::PathFault::none)
      profile.fail("chains." + declared.name + ".path", explain(found, result.spec, executive));
    result.chain = found.chain;
    result.chain.source_interval_ns = std::llround(result.spec.source_interval_ms * 1e6);
    result.bound = rt::chain_bound(table, result.chain);
    hold_to_bounds(profile, result, executive);
    check_batch(result, executive, warnings);
    for (const auto& port : builder.ports()) {
      const rt::ChainLeg& first = result.chain.legs[0];
      if (result.chain.from_stream && &port->stream() == executive.group(first.group).streams[first.port])
        result.arrivals = &port->keep_arrivals(kArrivals);
    }
    chains.push_back(std::move(result));
  }
  return chains;
}

ChainResult chain_result(const DeclaredChain& chain) {
  ChainResult result;
  result.name = chain.spec.name;
  result.path = chain.spec.path;
  result.exact = chain.bound.exact;
  result.reaction_us = static_cast<double>(chain.bound.reaction_ns) * 1e-3;
  result.age_us = static_cast<double>(chain.bound.age_ns) * 1e-3;
  result.max_reaction_us = chain.spec.max_reaction_ms * 1e3;
  result.max_age_us = chain.spec.max_age_ms * 1e3;
  result.source_interval_us = chain.spec.source_interval_ms * 1e3;
  return result;
}

}  // namespace sortie::firmware
