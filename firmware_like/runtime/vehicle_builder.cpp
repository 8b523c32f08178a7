// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/vehicle_builder.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware_like/runtime/kept_map.hpp"

namespace sortie::firmware {

const char* VehicleBuilder::keep(const std::string& name) {
  names_.push_back(std::make_unique<std::string>(name));
  return names_.back()->c_str();
}

void VehicleBuilder::check() const {
  if (executive_.error() != nullptr) profile_.fail("scene", executive_.error());
}

const KeptMap* VehicleBuilder::kept_map(const std::string& table) {
  maps_asked_.push_back(table);
  const auto map = std::find_if(kept_maps_.begin(), kept_maps_.end(),
                                [&table](const KeptMap& one) { return one.table == table; });
  return map == kept_maps_.end() ? nullptr : &*map;
}

const KeptMap* VehicleBuilder::unused_kept_map() const {
  for (const KeptMap& map : kept_maps_) {
    if (std::find(maps_asked_.begin(), maps_asked_.end(), map.table) == maps_asked_.end()) return &map;
  }
  return nullptr;
}

bool VehicleBuilder::archive_memory(const rt::TaskBase& task, rt::Archive& archive) const {
  bool declared = false;
  for (const auto& [owner, memory] : memories_) {
    if (owner != &task) continue;
    memory(archive);
    declared = true;
  }
  return declared;
}

rt::GroupId VehicleBuilder::group(const std::string& name, double default_rate_hz) {
  for (std::uint16_t i = 0; i < executive_.group_count(); ++i) {
    if (executive_.group(i).spec.name == name) return {i};
  }
  const std::string below = "groups." + name + ".";
  const std::string path = below + "rate_hz";
  const double rate = profile_.number(path, {default_rate_hz, 0.01, 1e5, "Hz", "releases a second"});
  const double ticks = 1e9 / rate / static_cast<double>(executive_.base_tick_ns());
  const double whole = std::round(ticks);
  if (whole < 1 || std::fabs(ticks - whole) > 1e-9 * ticks) {
    const double base_hz = 1e9 / static_cast<double>(executive_.base_tick_ns());
    std::ostringstream why;
    why << rate << " Hz is no whole number of base ticks (" << executive_.base_tick_ns() / 1000
        << " us); nearest legal: ";
    if (std::floor(ticks) >= 1) why << base_hz / std::floor(ticks) << " and ";
    why << base_hz / std::fmax(1.0, std::ceil(ticks)) << " Hz";
    profile_.fail(path, why.str());
  }
  rt::GroupSpec spec;
  spec.name = keep(name);
  spec.period_ticks = static_cast<std::uint32_t>(whole);
  spec.deadline_ticks = static_cast<std::uint32_t>(
      profile_.integer(below + "deadline_ticks",
                       {0, 0, whole, "ticks", "outputs become visible then; 0: at the period's end"}));
  spec.core = static_cast<int>(
      profile_.integer(below + "core", {-1, -1, 255, "", "processor of the live worker, -1: any"}));
  const std::string overrun =
      profile_.text(below + "overrun", "skip",
                    "live releases whose time has passed: leave them out, run some late, or end the run",
                    {"skip", "catch_up", "stop"});
  spec.policy = overrun == "stop"       ? rt::OverrunPolicy::stop
                : overrun == "catch_up" ? rt::OverrunPolicy::catch_up
                                        : rt::OverrunPolicy::skip;
  spec.catch_up = static_cast<std::uint32_t>(profile_.integer(
      below + "catch_up",
      {4, 1, 1000, "", "most late releases in a row that overrun = \"catch_up\" still runs"}));
  spec.firm.k = static_cast<std::uint8_t>(profile_.integer(
      below + "firm_k",
      {0, 0, 64, "", "of so many releases in a row firm_m are met, or an event says so; 0: no promise"}));
  spec.firm.m = static_cast<std::uint8_t>(profile_.integer(below + "firm_m", {0, 0, 64, "", "see firm_k"}));
  if (spec.firm.m > spec.firm.k) profile_.fail(below + "firm_m", "must not be above firm_k");
  const rt::GroupId id = executive_.add_group(spec);
  check();
  return id;
}

rt::TaskSpec VehicleBuilder::task_spec(const std::string& name, const TaskDefaults& defaults) {
  const std::string below = "tasks." + name + ".";
  rt::TaskSpec spec;
  spec.name = keep(name);
  spec.budget_us = static_cast<std::uint32_t>(profile_.number(
      below + "budget_us", {defaults.budget_us, 1, 1e7, "us", "declared worst run time of one execution"}));
  if (defaults.units != 0) {
    const NumberSpec units{static_cast<double>(defaults.units), 1, 4e9, "units",
                           "work units that one execution may spend"};
    std::optional<std::int64_t> said;
    if (defaults.auto_units) {
      said = profile_.integer_or_auto(below + "units", units);
      if (!said) auto_units_.push_back(name);
    } else {
      said = profile_.integer(below + "units", units);
    }
    spec.units = static_cast<std::uint32_t>(said.value_or(defaults.units));
  }
  static const char* const kNames[] = {"A", "B", "C"};
  const std::string criticality =
      profile_.text(below + "criticality", kNames[static_cast<int>(defaults.criticality)],
                    "under overload C gives way before B, and A never", {"A", "B", "C"});
  spec.criticality = static_cast<rt::Criticality>(criticality[0] - 'A');
  return spec;
}

rt::StaleRule VehicleBuilder::stale_rule(const std::string& name) {
  const double ms =
      profile_.number("stale." + name + "_ms",
                      {0, 0, 1e6, "ms", "silent for longer than this is stale, and counted; 0: never"});
  rt::StaleRule rule;
  rule.after_ticks =
      static_cast<std::uint32_t>(std::ceil(ms * 1e6 / static_cast<double>(executive_.base_tick_ns())));
  rule.hide = profile_.flag("stale." + name + "_hide", false, "a stale value is not shown to its reader");
  return rule;
}

bool VehicleBuilder::wants(const std::string& task, bool fallback) {
  const bool wanted =
      profile_.flag("tasks." + task + ".enabled", fallback, "false: not scheduled, and no memory for it");
  if (!wanted && std::find(left_out_.begin(), left_out_.end(), task) == left_out_.end())
    left_out_.push_back(task);
  return wanted;
}

ParameterGroup& VehicleBuilder::parameter_group(rt::GroupId group, const std::string& path) {
  for (const auto& known : parameters_.groups) {
    if (known->group == group.index) return *known;
  }
  const rt::Group& owner = executive_.group(group.index);
  if (!owner.tasks.empty())
    profile_.fail(path, "the first parameter of a group must be declared before the group's first task");
  const std::string name = owner.spec.name;
  ParameterGroup* added = parameters_.groups.emplace_back(std::make_unique<ParameterGroup>()).get();
  added->group = group.index;
  // No stream() of the builder: a change does not grow stale.
  const std::string channel = std::string(drivers::kChannelChange) + "_" + name;
  added->stream =
      executive_.add_stream<rt::ParameterChange>(group, keep(channel), kWaitingChanges, kWaitingChanges);
  check();
  auto port = std::make_unique<InputPort<rt::ParameterChange>>(channel, *added->stream);
  added->port = port.get();
  ports_.push_back(std::move(port));
  added->task = task<rt::ParameterState>(group, "parameters_" + name, 10, ApplyChanges{added});
  remembers(added->task);  // its function archives the table itself
  return *added;
}

void VehicleBuilder::parameter(rt::GroupId group, const std::string& path, ParameterSetter set) {
  if (!wants("parameters")) return;
  const ProfileKey key = profile_.changeable(path);  // a copy: the group's task declares keys of its own
  ParameterGroup& owner = parameter_group(group, path);
  owner.setters.push_back(std::make_unique<ParameterSetter>(std::move(set)));
  const Status status = owner.table.add(
      keep(path), key, key.number,
      [](void* self, double value) { return (*static_cast<ParameterSetter*>(self))(value); },
      owner.setters.back().get());
  if (status == Status::full)
    profile_.fail(path, "a group has at most " + std::to_string(rt::kMaxParametersPerGroup) + " parameters");
  if (status != Status::ok)
    profile_.fail(path, "cannot be a run-time parameter: declared twice, or its name is longer than " +
                            std::to_string(rt::kMaxParameterName) + " bytes");
  parameters_.all.push_back({&owner, owner.table.size() - 1});
}

double VehicleBuilder::parameter(rt::GroupId group, const std::string& path, const NumberSpec& spec,
                                 double* target) {
  *target = profile_.number(path, spec);
  parameter(group, path, [target](double value) {
    *target = value;
    return Status::ok;
  });
  return *target;
}

std::pair<ScanStream*, ScanPort*> VehicleBuilder::scans(rt::GroupId reader, const std::string& channel,
                                                        std::uint32_t buffers, std::uint32_t points) {
  auto* stream =
      executive_.add_pooled_stream<rt::ScanHeader, rt::ScanPoint>(reader, keep(channel), buffers, points);
  check();
  auto port = std::make_unique<ScanPort>(channel, *stream);
  ScanPort* handle = port.get();
  ports_.push_back(std::move(port));
  apply_stale_rule(*stream, channel);
  return {stream, handle};
}

}  // namespace sortie::firmware
