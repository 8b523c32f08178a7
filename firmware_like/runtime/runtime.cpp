// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/runtime.hpp"

#include <sys/mman.h>
#include <unistd.h>
#include <algorithm>
#include <new>

#include "firmware_like/runtime/kept_map.hpp"
#include "rt/math.hpp"

namespace sortie::firmware {

namespace {

// Address space to build in: pages that nobody touches cost nothing, and what is left over is given back. It
// grows until everything fits, as a 32-bit processor has little of it.
constexpr std::size_t kFirstMemory = std::size_t{32} << 20;
constexpr std::size_t kMostMemory = sizeof(void*) == 8 ? std::size_t{32} << 30 : std::size_t{1} << 30;

std::byte* map_memory(std::size_t bytes) {
  void* memory =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return static_cast<std::byte*>(memory);
}

InitialPose read_initial(Profile& profile, const RuntimeStart& start) {
  InitialPose pose = start.initial;
  const double x =
      profile.number("initial.x_m", {0, -1e6, 1e6, "m", "start position in the world, if no log gives one"});
  const double y =
      profile.number("initial.y_m", {0, -1e6, 1e6, "m", "start position in the world, if no log gives one"});
  const double z =
      profile.number("initial.z_m", {0, -1e6, 1e6, "m", "start position in the world, if no log gives one"});
  const double yaw =
      profile.number("initial.yaw_deg", {0, -360, 360, "deg", "start heading, if no log gives one"});
  if (!start.has_initial) {
    pose.p_world_body_m[0] = x;
    pose.p_world_body_m[1] = y;
    pose.p_world_body_m[2] = z;
    const rt::SinCos half = rt::sincos(yaw * 3.14159265358979323846 / 360.0);
    pose.q_world_body[0] = half.cos;
    pose.q_world_body[3] = half.sin;
  }
  return pose;
}

}  // namespace

Runtime::Runtime(Profile profile, const VehicleRegistry& vehicles, const RuntimeStart& start)
    : profile_(std::move(profile)) {
  for (mapped_bytes_ = kFirstMemory; !fits(vehicles, start); mapped_bytes_ *= 4) {
    if (mapped_bytes_ > kMostMemory / 4) throw std::bad_alloc();
  }
  memory_bytes_ = static_cast<std::size_t>(arena_->needed_bytes());
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t kept = (memory_bytes_ + page - 1) / page * page;
  arena_->end_at(memory_bytes_);
  if (kept < mapped_bytes_ && ::munmap(mapping_ + kept, mapped_bytes_ - kept) == 0) mapped_bytes_ = kept;
}

bool Runtime::fits(const VehicleRegistry& vehicles, const RuntimeStart& start) {
  mapping_ = map_memory(mapped_bytes_);
  try {
    build(vehicles, start);
    if (arena_->refused() == 0) {
      profile_.refuse_unknown_keys("", "hil");  // [hil] is for a test bench, if there is one
      return true;
    }
  } catch (...) {
    // Whatever went wrong may be for want of room; then it is tried again with more.
    if (!arena_ || arena_->refused() == 0) {
      drop();
      throw;
    }
  }
  drop();
  return false;
}

Runtime::~Runtime() { drop(); }

void Runtime::drop() {
  vehicle_.reset();
  builder_.reset();
  executive_.reset();
  arena_.reset();
  if (mapping_ != nullptr) ::munmap(mapping_, mapped_bytes_);
  mapping_ = nullptr;
}

void Runtime::build(const VehicleRegistry& vehicles, const RuntimeStart& start) {
  const auto tick_us = profile_.integer("time.base_tick_us", {1000, 50, 1e6, "us", "length of a tick"});
  const InitialPose initial = read_initial(profile_, start);
  live_settings_ = read_live_settings(profile_);
  outlets_ = read_run_outlets(profile_);
  arena_ = std::make_unique<rt::Arena>(std::span<std::byte>(mapping_, mapped_bytes_));
  executive_ =
      std::make_unique<rt::Executive>(*arena_, tick_us * rt::kNanosecondsPerMicrosecond, start.epoch_ns);
  builder_ = std::make_unique<VehicleBuilder>(profile_, *executive_, initial, start.map);
  const auto factory = std::find_if(vehicles.begin(), vehicles.end(),
                                    [this](const auto& entry) { return entry.first == profile_.vehicle(); });
  if (factory == vehicles.end()) {
    std::string known;
    for (const auto& [name, unused] : vehicles) known += (known.empty() ? "" : ", ") + name;
    profile_.fail("scene.vehicle", "unknown vehicle \"" + profile_.vehicle() + "\"; known: " + known);
  }
  vehicle_ = factory->second(*builder_);
  if (!builder_->uses_kept_map())
    throw ProfileError("--map " + start.map->path + ": scene " + profile_.name() +
                       " has no part that uses a " +
                       (start.map->table == "join" ? "cloud" : "map of surfaces") +
                       "; leave out --map, or add --set tasks." + start.map->table + ".enabled=true");
  read_parameter_keys();
  if (executive_->seal() != Status::ok) profile_.fail("scene", executive_->error());
  schedule_ = check_schedule(profile_, *executive_);
  chains_ = read_chains(profile_, *builder_, *executive_, schedule_.warnings);
  bus_ = check_bus(profile_, builder_->bus_frames(), schedule_.warnings);
}

std::vector<PoolResult> Runtime::memory_plan() const {
  std::vector<PoolResult> plan;
  for (const rt::PoolRecord& record : arena_->report()) {
    auto entry = std::find_if(plan.begin(), plan.end(),
                              [&record](const PoolResult& pool) { return pool.name == record.name; });
    if (entry == plan.end()) entry = plan.insert(plan.end(), PoolResult{record.name, 0, 0, 0, 0});
    entry->capacity += record.capacity;
    entry->bytes += record.bytes;
  }
  return plan;
}

std::string Runtime::group_table() const {
  std::string table;
  const auto us = [this](std::uint64_t ticks) {
    return std::to_string(static_cast<std::int64_t>(ticks) * executive_->base_tick_ns() / 1000);
  };
  for (std::uint32_t i = 0; i < executive_->group_count(); ++i) {
    const rt::Group& group = executive_->group(i);
    table += std::string(group.spec.name) + " " + us(group.timing.period) + " " + us(group.timing.phase) +
             " " + us(group.timing.deadline);
    for (const rt::TaskBase* task : group.tasks) table += " " + std::string(task->name());
    table += "\n";
  }
  return table;
}

std::string Runtime::task_table() const {
  std::string table;
  for (std::uint32_t i = 0; i < executive_->task_count(); ++i) {
    const rt::TaskBase& task = executive_->task(i);
    const rt::Group& group = executive_->group(task.group());
    table += std::string(task.name()) + " " + group.spec.name + " " +
             std::to_string(group.timing.period * executive_->base_tick_ns() / 1000) + " " +
             std::to_string(task.budget_us()) + "\n";
  }
  return table;
}

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
